"""YAML documents: loaded safely with the line of each value, and written."""

from __future__ import annotations

import re
from collections.abc import Callable, Hashable
from dataclasses import field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import yaml
from pydantic import ValidationError
from yaml.composer import Composer
from yaml.constructor import ConstructorError, SafeConstructor
from yaml.parser import Parser
from yaml.reader import Reader
from yaml.resolver import Resolver
from yaml.scanner import Scanner

from .collector import paused_collector
from .dataclass import dataclass
from .problems import MOST_MISFITS, InputError, Place, Problem, UserError, field_name, misfits
from .reading import read_text

if TYPE_CHECKING:
    from pydantic import BaseModel


def safe_loader(text: str) -> Any:
    """Return a safe YAML loader for `text`.

    It uses LibYAML's parser if available, which is five times as fast. Nodes are composed in Python
    in any case, so that too deep nesting raises an error instead of a crash.
    """
    return _WithLibYaml(text) if yaml.__with_libyaml__ else _Plain(text)


MOST_VALUES = 300_000
"""Maximum number of values in a document. A floor of 10,000 obstacles has 100,000."""

HUGE = 10**1000
"""Largest whole number. Python refuses to print one of 4,300 digits."""


class _Counting(Composer):
    """Composer that raises `UserError` if there are too many nodes."""

    def __init__(self) -> None:
        Composer.__init__(self)
        self._values = 0

    def descend_resolver(self, parent: yaml.Node | None, index: object) -> None:
        """Count a value. PyYAML calls this for each node, to resolve tags by path.

        Keys have no index.
        """
        self._values += index is not None
        if self._values > MOST_VALUES:
            raise UserError(too_many())

    def ascend_resolver(self) -> None:
        """Do nothing after a node."""


def too_many() -> str:
    """Return the message about a document with more than `MOST_VALUES` values."""
    return f"it has more than {MOST_VALUES:,} values"


class _Resolver(Resolver):
    """Resolver that also reads -.5 as a number, like YAML 1.1."""


class _Constructor(SafeConstructor):
    """Constructor whose errors have the line of the value."""


def _placed(construct: Callable[[Any, yaml.Node], Any]) -> Callable[[Any, yaml.Node], Any]:
    def placed(loader: Any, node: yaml.Node) -> Any:
        try:
            value = construct(loader, node)
        except (AttributeError, LookupError, OverflowError, TypeError, ValueError):
            # PyYAML's constructors raise these if a value does not match its tag: `!!bool maybe`.
            tag, text = node.tag.rpartition(":")[2], str(node.value)
            raise _misfit(node, f"{text[:60]!r} is not what its tag (!!{tag}) says") from None
        if isinstance(value, int) and abs(value) > HUGE:
            raise _misfit(node, "a whole number of more than 1,000 digits")
        return value

    return placed


def _misfit(node: yaml.Node, message: str) -> ConstructorError:
    return ConstructorError(None, None, message, node.start_mark)


def _decimal(construct: Callable[[Any, yaml.Node], Any]) -> Callable[[Any, yaml.Node], Any]:
    """Return a constructor that reads 10:30 as text. In YAML 1.1 it is a number of base 60."""

    def constructed(loader: Any, node: yaml.Node) -> Any:
        return node.value if ":" in str(node.value) else construct(loader, node)

    return constructed


for _tag, _construct in SafeConstructor.yaml_constructors.items():
    _is_number = _tag in ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")
    _Constructor.add_constructor(_tag, _placed(_decimal(_construct) if _is_number else _construct))


class _Plain(Reader, Scanner, Parser, _Counting, _Constructor, _Resolver):
    def __init__(self, text: str) -> None:
        Reader.__init__(self, text)
        Scanner.__init__(self)
        Parser.__init__(self)
        _Counting.__init__(self)
        _Constructor.__init__(self)
        _Resolver.__init__(self)


if yaml.__with_libyaml__:
    from yaml._yaml import CParser

    class _WithLibYaml(_Counting, CParser, _Constructor, _Resolver):
        def __init__(self, text: str) -> None:
            CParser.__init__(self, text)
            _Counting.__init__(self)
            _Constructor.__init__(self)
            _Resolver.__init__(self)


MOST_TEXT = 4_000_000
"""Maximum number of characters of a document. Longer ones take minutes to parse."""

UNWRITABLE = re.compile("[\0-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff]")
"""Rejected characters. Names of files and JSON cannot have lone surrogates, and terminals interpret
control characters."""

_Schema = TypeVar("_Schema", bound="BaseModel")


@dataclass(frozen=True)
class Document:
    """Values of a YAML file, with their lines."""

    file: str
    data: Any = field(repr=False)
    lines: dict[Place, int] = field(repr=False)
    at: Place = ()
    """Place of the values in the file, if this is a part of it."""

    def part(self, key: str) -> Document:
        """Return the values of an outermost key as a document."""
        lines = {place[1:]: line for place, line in self.lines.items() if place[:1] == (key,)}
        return Document(self.file, self.data[key], lines, (*self.at, key))

    def problem(self, message: str, *place: str | int) -> Problem:
        """Return a problem at the value with this `place`, or at the nearest value around it."""
        nearest = place
        while nearest and nearest not in self.lines:
            nearest = nearest[:-1]
        return Problem(message, field_name((*self.at, *place)), self.lines.get(nearest))

    def checked(
        self,
        schema: type[_Schema],
        error: type[InputError],
        context: Any = None,
        part: type[_Schema] | None = None,
    ) -> _Schema:
        """Return the values as a `schema`, or a `part` of it. Raise an `error` with all problems.

        Pydantic's validators get the `context`.
        """
        if not isinstance(self.data, dict):
            kind = "nothing" if self.data is None else "a " + _kind(self.data)
            message = f"expected keys with values, found {kind}"
            raise error(self.file, [self.problem(message)])
        try:
            return (part or schema).model_validate(self.data, context=context)
        except ValidationError as why:
            problems = [
                self.problem(message, *place) for message, place in misfits(why, schema, self.data)
            ]
            if (count := why.error_count()) > MOST_MISFITS:
                message = f"{count:,} values are not what they should be; the first are:"
                problems.insert(0, Problem(message))
            raise error(self.file, problems) from None


def read_yaml(path: Path, error: type[InputError]) -> Document:
    """Return the document in the YAML file at `path`. Raise `error` if it is invalid."""
    return parse_yaml(read_text(path, error), str(path), error)


def parse_yaml(text: str, file: str, error: type[InputError]) -> Document:
    """Return the document in `text`, the contents of `file`. Raise `error` if it is invalid."""
    if len(text) > MOST_TEXT:
        message = f"is longer than {MOST_TEXT:,} characters, which is more than anybody writes"
        raise error.of(file, message)
    if odd := yaml.reader.Reader.NON_PRINTABLE.search(text):
        at = text.count("\n", 0, odd.start()) + 1
        message = f"is not YAML: the character U+{ord(odd.group()):04X} is not allowed"
        raise error.of(file, message, line=at)
    loader = None
    try:
        loader = safe_loader(text)
        with paused_collector():
            node = loader.get_single_node()
            if node is None:
                return Document(file, None, {(): 1})
            lines: dict[Place, int] = {}
            problems = _survey(node, (), lines, frozenset())
            if problems:
                raise error(file, problems)
            return Document(file, loader.construct_document(node), lines)
    except InputError:
        raise
    except yaml.MarkedYAMLError as why:
        mark = why.problem_mark or why.context_mark
        reason = " ".join(part for part in (why.problem, why.context) if part)
        if mark and re.match(r"[ -]*\t", "".join(text.splitlines()[mark.line : mark.line + 1])):
            reason = "a tab begins this line; indent it by spaces"
        if "maximum nesting depth" in reason:  # limit of LibYAML 0.2.6
            reason = "it is nested too deeply"
        # LibYAML marks the end of a text as the line after the last.
        line = min(mark.line + 1, len(text.splitlines())) if mark else None
        raise error.of(file, f"is not YAML: {reason}", line=line) from None
    except RecursionError:
        raise error.of(file, "is not YAML: it is nested too deeply") from None
    except (yaml.YAMLError, ValueError) as why:
        raise error.of(file, f"is not YAML: {why}") from None
    finally:
        if loader is not None:
            loader.dispose()


def _survey(
    node: yaml.Node, place: Place, lines: dict[Place, int], above: frozenset[int]
) -> list[Problem]:
    """Add the lines of all values under `node`, and return the problems of its keys."""
    if id(node) in above:
        return [Problem("an alias (*) to something that contains it", field_name(place))]
    if len(lines) > MOST_VALUES:
        raise UserError(too_many())  # because each use of an alias counts
    lines.setdefault(place, node.start_mark.line + 1)
    if isinstance(node, yaml.ScalarNode) and (odd := UNWRITABLE.search(node.value)):
        problem = f"a text can't have the character U+{ord(odd.group()):04X}"
        return [Problem(problem, field_name(place), node.start_mark.line + 1)]
    within = above | {id(node)}
    problems: list[Problem] = []
    if isinstance(node, yaml.SequenceNode):
        for index, child in enumerate(node.value):
            problems += _survey(child, (*place, index), lines, within)
    elif isinstance(node, yaml.MappingNode):
        keys: set[Hashable] = set()
        for key, child in node.value:
            line = key.start_mark.line + 1
            if not isinstance(key, yaml.ScalarNode):
                problems.append(Problem("a key is plain text", field_name(place), line))
                continue
            problems += _survey(key, place, lines, within)
            inner = (*place, str(key.value))
            if key.value in keys and key.tag != "tag:yaml.org,2002:merge":
                problems.append(Problem("this key stands twice", field_name(inner), line))
            keys.add(key.value)
            lines.setdefault(inner, line)
            problems += _survey(child, inner, lines, within)
    return problems


def _kind(value: object) -> str:
    return {list: "list", str: "text", bool: "yes/no value"}.get(type(value), "number")


def yaml_text(data: Any) -> str:
    """Return `data` as YAML with outermost keys on separate lines and innermost values on one."""
    text: str = yaml.dump(
        data, Dumper=_Dumper, sort_keys=False, allow_unicode=True, default_flow_style=None
    )
    return text


class _Dumper(yaml.SafeDumper):
    """Dumper without anchors and aliases, which make files harder to read."""

    def ignore_aliases(self, data: Any) -> bool:
        """Return True, so that repeated values are written again."""
        return True

    def represent(self, data: Any) -> None:
        """Write `data` with the outermost keys on separate lines and innermost values on one."""
        node: Any = self.represent_data(data)
        node.flow_style = False
        self.serialize(node)


_SIGNED = re.compile(r"[-+]\.[0-9][0-9_]*(?:[eE][-+][0-9]+)?$")
for _kind_of in (_Resolver, _Dumper):
    _kind_of.add_implicit_resolver("tag:yaml.org,2002:float", _SIGNED, ["-", "+"])
