"""The rosbridge v2 protocol: its operations as JSON, checked, and long messages in fragments."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError
from pydantic_core import from_json

from .ledger import Account, size_of

LONGEST_MESSAGE = 1_000_000
"""Characters. A longer message is refused."""

LONGEST_NAME = 256
"""Characters. The longest name of a topic or a service, and the longest id."""

_MOST_UNFINISHED = 16
"""How many messages one client may have in pieces at once."""

_UNFINISHED = 1000
"""Bytes. The place that a message in pieces takes, beside them."""

_MOST_FRAGMENTS = 10_000
_SMALLEST_FRAGMENT = 64

Level = Literal["error", "warning", "info", "none"]
LEVELS: tuple[Level, ...] = ("none", "error", "warning", "info")
"""Of status messages, from telling nothing to telling everything."""


class ProtocolError(ValueError):
    """Something that is no operation of the protocol; `id` is its id, if it gave one."""

    def __init__(self, message: str, id: str | int | None = None) -> None:
        super().__init__(message)
        self.id = id


_Name = Annotated[str, Field(min_length=1, max_length=LONGEST_NAME)]
_Id = Annotated[str, Field(max_length=LONGEST_NAME)] | int | None
_Count = Annotated[int, Field(ge=0, le=1_000_000_000)]


class _Operation(BaseModel):
    model_config = ConfigDict(extra="ignore", strict=True)
    id: _Id = None


class Advertise(_Operation):
    """The client will publish on a topic."""

    op: Literal["advertise"]
    topic: _Name
    type: _Name


class Unadvertise(_Operation):
    """The client won't publish on a topic any more."""

    op: Literal["unadvertise"]
    topic: _Name


class Publish(_Operation):
    """A message on a topic."""

    op: Literal["publish"]
    topic: _Name
    msg: Any


class Subscribe(_Operation):
    """The client wants a topic's messages; `throttle_rate` in milliseconds between them."""

    op: Literal["subscribe"]
    topic: _Name
    type: _Name | None = None
    throttle_rate: Annotated[float, Field(ge=0, le=1e9, allow_inf_nan=False)] | None = None
    queue_length: _Count | None = None
    fragment_size: Annotated[int, Field(ge=1)] | None = None
    compression: str | None = None


class Unsubscribe(_Operation):
    """The client doesn't want a topic any more; with an id, that subscription."""

    op: Literal["unsubscribe"]
    topic: _Name


class CallService(_Operation):
    """A request to a service."""

    op: Literal["call_service"]
    service: _Name
    args: dict[str, Any] | list[Any] | None = None
    fragment_size: Annotated[int, Field(ge=1)] | None = None
    compression: str | None = None


class SetLevel(_Operation):
    """Which status messages the client wants."""

    op: Literal["set_level"]
    level: Level


class Status(_Operation):
    """What a client has to say about how it is; taken, and left at that."""

    op: Literal["status"]
    level: str | None = None
    msg: Any = None


class Fragment(_Operation):
    """A piece of a message."""

    op: Literal["fragment"]
    id: Annotated[str, Field(max_length=LONGEST_NAME)] | int
    data: str
    num: _Count
    total: Annotated[int, Field(ge=1, le=_MOST_FRAGMENTS)]


Operation = (
    Advertise
    | Unadvertise
    | Publish
    | Subscribe
    | Unsubscribe
    | CallService
    | SetLevel
    | Status
    | Fragment
)
_OPERATION: TypeAdapter[Operation] = TypeAdapter(Annotated[Operation, Field(discriminator="op")])


def decode(text: str | bytes) -> Operation:
    """The operation that `text` is; `ProtocolError` says what is wrong with it."""
    if len(text) > LONGEST_MESSAGE:
        raise ProtocolError(
            f"a message of {len(text)} characters; {LONGEST_MESSAGE} is the most that is taken"
        )
    try:
        data = from_json(text, allow_inf_nan=False)
    except ValueError as why:
        raise ProtocolError(f"not JSON: {why}") from None
    if not isinstance(data, dict) or not isinstance(data.get("op"), str):
        raise ProtocolError('not a message of rosbridge: an object with the field "op"')
    try:
        return _OPERATION.validate_python(data)
    except ValidationError as errors:
        raise ProtocolError(_sentence(data["op"], errors), _id_of(data)) from None


def encode(operation: dict[str, Any]) -> str:
    """An operation as JSON."""
    return json.dumps(operation, separators=(",", ":"), allow_nan=False)


def publication(topic: str, message: dict[str, Any]) -> str:
    """A message on a topic, as JSON."""
    return encode({"op": "publish", "topic": topic, "msg": message})


def status(level: Level, message: str, id: str | int | None = None) -> str:
    """A status message, as JSON."""
    told: dict[str, Any] = {"op": "status", "level": level, "msg": message}
    return encode(told if id is None else {**told, "id": id})


def fragments(text: str, size: int, id: str) -> Iterator[str]:
    """`text`, or where it is longer than `size` characters the fragments of it."""
    if len(text) <= size:
        yield text
        return
    size = max(size, _SMALLEST_FRAGMENT)
    total = -(-len(text) // size)
    for num in range(total):
        data = text[num * size : (num + 1) * size]
        yield encode({"op": "fragment", "id": id, "data": data, "num": num, "total": total})


class Reassembly:
    """Puts the fragments of one client's messages together again; `account` counts them."""

    def __init__(self, account: Account) -> None:
        self._account = account
        self._unfinished: dict[str | int, _Pieces] = {}

    def add(self, fragment: Fragment) -> str | None:
        """The whole message, once all of it is there.

        `ProtocolError` where it gets too long, or too many are begun (the oldest one is given up).
        """
        if fragment.num >= fragment.total:
            raise ProtocolError(f"fragment {fragment.num} of {fragment.total}", fragment.id)
        if fragment.id not in self._unfinished:
            self._account.add(_UNFINISHED)
        pieces = self._unfinished.setdefault(fragment.id, _Pieces())
        self._account.add(pieces.add(fragment))
        if pieces.length > LONGEST_MESSAGE:
            self._give_up(fragment.id)
            raise ProtocolError(f"fragments of more than {LONGEST_MESSAGE} characters", fragment.id)
        if len(pieces.data) == fragment.total:
            self._give_up(fragment.id)
            return "".join(pieces.data[num] for num in sorted(pieces.data))
        if len(self._unfinished) > _MOST_UNFINISHED:
            oldest = next(iter(self._unfinished))
            self._give_up(oldest)
            raise ProtocolError(f"{_MOST_UNFINISHED} messages in fragments are the most", oldest)
        return None

    def clear(self) -> None:
        """Give up everything that is not complete."""
        for id in list(self._unfinished):
            self._give_up(id)

    def _give_up(self, id: str | int) -> None:
        self._account.add(-_UNFINISHED - self._unfinished.pop(id).size)


class _Pieces:
    """What is there of one message: its fragments by number, their characters and bytes."""

    def __init__(self) -> None:
        self.data: dict[int, str] = {}
        self.length = 0
        self.size = 0

    def add(self, fragment: Fragment) -> int:
        """Take a fragment in, instead of the one of that number; the bytes that it adds."""
        before = self.data.get(fragment.num)
        added = size_of(fragment.data) - (0 if before is None else size_of(before))
        self.length += len(fragment.data) - len(before or "")
        self.size += added
        self.data[fragment.num] = fragment.data
        return added


def _id_of(data: dict[str, Any]) -> str | int | None:
    given = data.get("id")
    if isinstance(given, bool) or not isinstance(given, str | int):
        return None
    return given if len(str(given)) <= LONGEST_NAME else None


def _sentence(op: str, errors: ValidationError) -> str:
    first = errors.errors(include_url=False, include_context=False, include_input=False)[0]
    if first["type"] == "union_tag_invalid":
        return f"unknown operation {op[:60]!r}"
    place = ".".join(str(part) for part in first["loc"] if part != op)
    return f"{op}: {place}: {first['msg']}"
