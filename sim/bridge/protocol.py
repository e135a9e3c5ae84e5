"""Rosbridge v2 protocol: operations, fragments, and limits of memory per client.

Counts are close to the memory that Python uses: the size of each text in memory, and a constant
for each object around it, so that many small objects count as well.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, TypeAdapter, ValidationError
from pydantic_core import from_json

from ..competition.transport import RefusedError

_PLACE = 100
"""Bytes. Memory of a place in a queue, without the text."""


def size_of(text: str) -> int:
    """Return the size of a waiting text in bytes."""
    return sys.getsizeof(text) + _PLACE


class Ledger:
    """Accounts of all clients.

    A client for which more than `most_for_one` bytes are held is disconnected. If more than
    `most_for_all` bytes are held for all clients, the one with the largest share is disconnected.
    """

    def __init__(self, *, most_for_one: int = 8_000_000, most_for_all: int = 128_000_000) -> None:
        self.most_for_one = most_for_one
        self.most_for_all = most_for_all
        self.held = 0
        self.accounts: dict[Account, None] = {}


class Account:
    """Bytes that are held for one client.

    `let_go(why)` is called once when there are too many. After that, nothing is counted, and
    nothing may be held for the client.
    """

    def __init__(self, ledger: Ledger, let_go: Callable[[str], None]) -> None:
        self.held = 0
        self.let_go = let_go
        self._ledger = ledger
        ledger.accounts[self] = None

    @property
    def is_closed(self) -> bool:
        """Whether the client has gone or is being disconnected."""
        return self not in self._ledger.accounts

    def add(self, size: int) -> None:
        """Add `size` bytes, which may be negative."""
        if self.is_closed:
            return
        ledger = self._ledger
        self.held += size
        ledger.held += size
        if self.held > ledger.most_for_one:
            self.refuse(f"more than {ledger.most_for_one} bytes are held for this client")
        elif ledger.held > ledger.most_for_all:
            greatest = max(ledger.accounts, key=lambda account: account.held)
            greatest.refuse(
                f"more than {ledger.most_for_all} bytes are held for all clients,"
                " and most of them for this one"
            )

    def refuse(self, why: str) -> None:
        """Disconnect the client, unless it is being disconnected."""
        if not self.is_closed:
            self.close()
            self.let_go(why)

    def close(self) -> None:
        """Stop counting, because the client has gone."""
        if not self.is_closed:
            del self._ledger.accounts[self]
            self._ledger.held -= self.held
            self.held = 0


LONGEST_MESSAGE = 1_000_000
"""Characters. Longer messages are rejected."""

LONGEST_NAME = 256
"""Characters. The longest name of a topic or a service, and the longest id."""

_MOST_UNFINISHED = 16
"""How many incomplete messages one client may have at once."""

_UNFINISHED = 1000
"""Bytes. The memory of an incomplete message beside its fragments."""

_MOST_FRAGMENTS = 10_000
_SMALLEST_FRAGMENT = 64

Level = Literal["error", "warning", "info", "none"]
LEVELS: tuple[Level, ...] = ("none", "error", "warning", "info")
"""Levels of status messages, from none to all."""


class ProtocolError(RefusedError):
    """Message that is no operation of the protocol. `id` is its id, if it has one."""

    def __init__(self, message: str, id: str | int | None = None) -> None:
        super().__init__(message)
        self.id = id


def absolute(name: str) -> str:
    """Return the full name of a topic or service, whose first / may be missing."""
    return name if name.startswith("/") else f"/{name}"


_Name = Annotated[str, Field(min_length=1, max_length=LONGEST_NAME)]
_Topic = Annotated[_Name, AfterValidator(absolute)]
_Id = Annotated[str, Field(max_length=LONGEST_NAME)] | int
_Count = Annotated[int, Field(ge=0, le=1_000_000_000)]
_Size = Annotated[int, Field(ge=1)]


class _Operation(BaseModel):
    model_config = ConfigDict(extra="ignore", strict=True)
    id: _Id | None = None


class Advertise(_Operation):
    """Announcement that the client publishes on a topic."""

    op: Literal["advertise"]
    topic: _Topic
    type: _Name


class Unadvertise(_Operation):
    """End of an announcement."""

    op: Literal["unadvertise"]
    topic: _Topic


class Publish(_Operation):
    """Message on a topic."""

    op: Literal["publish"]
    topic: _Topic
    msg: Any


class Subscribe(_Operation):
    """Request for the messages of a topic, at least `throttle_rate` milliseconds apart."""

    op: Literal["subscribe"]
    topic: _Topic
    type: _Name | None = None
    throttle_rate: Annotated[float, Field(ge=0, le=1e9, allow_inf_nan=False)] | None = None
    queue_length: _Count | None = None
    fragment_size: _Size | None = None
    compression: str | None = None


class Unsubscribe(_Operation):
    """End of the subscription with an id, or of all subscriptions of the client to a topic."""

    op: Literal["unsubscribe"]
    topic: _Topic


class CallService(_Operation):
    """Request to a service."""

    op: Literal["call_service"]
    service: _Name
    args: dict[str, Any] | list[Any] | None = None
    fragment_size: _Size | None = None
    compression: str | None = None


class SetLevel(_Operation):
    """Level of the status messages that the client gets."""

    op: Literal["set_level"]
    level: Level


class Status(_Operation):
    """Status message of the client, which has no effect."""

    op: Literal["status"]
    level: str | None = None
    msg: Any = None


class Fragment(_Operation):
    """Part of a message."""

    op: Literal["fragment"]
    id: _Id
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
    """Return the operation in a text. `ProtocolError` names the fault."""
    if len(text) > LONGEST_MESSAGE:
        raise ProtocolError(
            f"a message of {len(text)} characters; {LONGEST_MESSAGE} is the maximum"
        )
    try:
        data = from_json(text, allow_inf_nan=False)
    except ValueError as why:
        raise ProtocolError(f"not JSON: {_not_finite(text) or why}") from None
    if not isinstance(data, dict) or not isinstance(data.get("op"), str):
        raise ProtocolError('not a message of rosbridge: an object with the field "op"')
    try:
        return _OPERATION.validate_python(data)
    except ValidationError as errors:
        raise ProtocolError(_sentence(data["op"], errors), _id_of(data)) from None


def encode(operation: dict[str, Any]) -> str:
    """Return an operation as JSON."""
    return json.dumps(operation, separators=(",", ":"), allow_nan=False)


def publication(topic: str, message: dict[str, Any]) -> str:
    """Return a message on a topic as JSON."""
    return encode({"op": "publish", "topic": topic, "msg": message})


def status(level: Level, message: str, id: str | int | None = None) -> str:
    """Return a status message as JSON."""
    return encode(
        {"op": "status", "level": level, "msg": message} | ({} if id is None else {"id": id})
    )


def fragments(text: str, size: int, id: str) -> Iterator[str]:
    """Yield a text, or its fragments if it is longer than `size` characters."""
    if len(text) <= size:
        yield text
        return
    size = max(size, _SMALLEST_FRAGMENT)
    total = -(-len(text) // size)
    for num in range(total):
        data = text[num * size : (num + 1) * size]
        yield encode({"op": "fragment", "id": id, "data": data, "num": num, "total": total})


class Reassembly:
    """Joins the fragments of one client's messages; `account` counts their bytes."""

    def __init__(self, account: Account) -> None:
        self._account = account
        self._unfinished: dict[str | int, dict[int, str]] = {}
        self._lengths: dict[str | int, int] = {}

    def add(self, fragment: Fragment) -> str | None:
        """Return the whole message once it is complete.

        `ProtocolError` if the message is too long, or too many are incomplete. Then the oldest one
        is dropped.
        """
        id, num = fragment.id, fragment.num
        if num >= fragment.total:
            raise ProtocolError(f"fragment {num} of {fragment.total}", id)
        if id not in self._unfinished:
            self._unfinished[id], self._lengths[id] = {}, 0
            self._account.add(_UNFINISHED)
        pieces = self._unfinished[id]
        if num in pieces:
            self._account.add(-size_of(pieces[num]))
        # A repeated piece replaces the previous one.
        self._lengths[id] += len(fragment.data) - len(pieces.get(num, ""))
        pieces[num] = fragment.data
        self._account.add(size_of(fragment.data))
        if self._lengths[id] > LONGEST_MESSAGE:
            self._drop(id)
            raise ProtocolError(f"fragments of more than {LONGEST_MESSAGE} characters", id)
        if len(pieces) == fragment.total:
            self._drop(id)
            return "".join(pieces[num] for num in sorted(pieces))
        if len(self._unfinished) > _MOST_UNFINISHED:
            oldest = next(iter(self._unfinished))
            self._drop(oldest)
            raise ProtocolError(f"{_MOST_UNFINISHED} messages in fragments are the maximum", oldest)
        return None

    def clear(self) -> None:
        """Drop all incomplete messages."""
        for id in list(self._unfinished):
            self._drop(id)

    def _drop(self, id: str | int) -> None:
        pieces = self._unfinished.pop(id)
        del self._lengths[id]
        self._account.add(-_UNFINISHED - sum(map(size_of, pieces.values())))


def _not_finite(text: str | bytes) -> str:
    """Return which topic has a number that is not finite, if that is why a text is not JSON."""
    with suppress(ValueError):
        data = from_json(text, allow_inf_nan=True)
        if isinstance(data, dict) and "topic" in data:
            return f"{data['topic']!s:.60} has numbers that are not finite: {data.get('msg')!s:.60}"
    return ""


def _id_of(data: dict[str, Any]) -> str | int | None:
    id = data.get("id")
    if isinstance(id, bool) or not isinstance(id, str | int):
        return None
    return id if len(str(id)) <= LONGEST_NAME else None


def _sentence(op: str, errors: ValidationError) -> str:
    first = errors.errors(include_url=False, include_context=False, include_input=False)[0]
    if first["type"] == "union_tag_invalid":
        return f"unknown operation {op[:60]!r}"
    place = ".".join(str(part) for part in first["loc"] if part != op)
    return f"{op}: {place}: {first['msg']}"
