"""The fastest safe loader of YAML that is installed, with limits."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import yaml
from yaml.composer import Composer
from yaml.constructor import ConstructorError, SafeConstructor
from yaml.parser import Parser
from yaml.reader import Reader
from yaml.resolver import Resolver
from yaml.scanner import Scanner

from .problems import UserError


def safe_loader(text: str) -> Any:
    """Return a safe loader of `text`: PyYAML's, with LibYAML's parser where PyYAML has it.

    LibYAML is five times as fast. Nodes are composed in Python in any case, where nesting too
    deep is an error and not the end of the process.
    """
    return _WithLibYaml(text) if yaml.__with_libyaml__ else _Plain(text)


MOST_VALUES = 300_000
"""Most values of a document: a floor of 10,000 obstacles has 100,000."""

HUGE = 10**1000
"""Largest whole number: Python would refuse to write one of 4,300 digits out again."""


class _Counting(Composer):
    """Composes nodes, and stops where they are too many: `ValueError`."""

    def __init__(self) -> None:
        Composer.__init__(self)
        self._values = 0

    def descend_resolver(self, parent: yaml.Node | None, index: object) -> None:
        """Count a value: PyYAML calls this for each node, to resolve tags by path. Keys have no
        index."""
        self._values += index is not None
        if self._values > MOST_VALUES:
            raise UserError(too_many())

    def ascend_resolver(self) -> None:
        """Called after each node."""


def too_many() -> str:
    """Return the message about a document with more than `MOST_VALUES` values."""
    return f"it has more than {MOST_VALUES:,} values"


class _Constructor(SafeConstructor):
    """Constructs values; errors have the line of the value."""


def _placed(construct: Callable[[Any, yaml.Node], Any]) -> Callable[[Any, yaml.Node], Any]:
    def placed(loader: Any, node: yaml.Node) -> Any:
        try:
            value = construct(loader, node)
        except (AttributeError, LookupError, OverflowError, TypeError, ValueError):
            # So PyYAML's constructors end where a tag promises what is not there: `!!bool maybe`.
            tag, text = node.tag.rpartition(":")[2], str(node.value)
            raise _misfit(node, f"{text[:60]!r} is not what its tag (!!{tag}) says") from None
        if isinstance(value, int) and abs(value) > HUGE:
            raise _misfit(node, "a whole number of more than 1,000 digits")
        return value

    return placed


def _misfit(node: yaml.Node, message: str) -> ConstructorError:
    return ConstructorError(None, None, message, node.start_mark)


def _decimal(construct: Callable[[Any, yaml.Node], Any]) -> Callable[[Any, yaml.Node], Any]:
    """Return a constructor that takes 10:30 for text: to YAML 1.1 it is a number of base 60."""

    def constructed(loader: Any, node: yaml.Node) -> Any:
        return node.value if ":" in str(node.value) else construct(loader, node)

    return constructed


for _tag, _construct in SafeConstructor.yaml_constructors.items():
    _is_number = _tag in ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")
    _Constructor.add_constructor(_tag, _placed(_decimal(_construct) if _is_number else _construct))


class _Plain(Reader, Scanner, Parser, _Counting, _Constructor, Resolver):
    def __init__(self, text: str) -> None:
        Reader.__init__(self, text)
        Scanner.__init__(self)
        Parser.__init__(self)
        _Counting.__init__(self)
        _Constructor.__init__(self)
        Resolver.__init__(self)


if yaml.__with_libyaml__:
    from yaml._yaml import CParser

    class _WithLibYaml(_Counting, CParser, _Constructor, Resolver):
        def __init__(self, text: str) -> None:
            CParser.__init__(self, text)
            _Counting.__init__(self)
            _Constructor.__init__(self)
            Resolver.__init__(self)
