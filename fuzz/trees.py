"""Damages to the values in a YAML or JSON file: what somebody gets wrong who knows the format."""

from __future__ import annotations

import copy
import json
import math
from random import Random
from typing import Any

DEEP = "@deep@"
"""Stands for lists within lists, more than can be written by recursion."""

ODD_NUMBERS: tuple[Any, ...] = (
    *(0, 1, -1, 2, 7, 3.5, -0.0, 0.1, 1e-12, 5e-324, 255, 256, 65536, 1e6, -1e6, 1e9, 1e12),
    *(2**31, 2**63, -(2**63), 2**64, 10**30, 10**400, 1e16, 1e155, 1e308, -1e308),
    *(math.nan, math.inf, -math.inf, True, False, None),
)
ODD_TEXTS: tuple[str, ...] = (
    *("", " ", "a", "x" * 300, "x" * 20_000, "é", "\U0001f600", "日本語", "\x00", "\x1b[31m", "\t"),
    *("\u2028", "\ufeff", "\ud800", "a\nb", "line\r\n", "../x", "../../etc/passwd", "/", ".", "~"),
    *("null", "true", "yes", "1", "1e3", "-1", "nan", ".inf", "0x10", "1:30", "2023-01-01", "="),
    *("<<", "*", "&a", "!!int", "%", "{}", "[]", "'", '"', "\\", "{{", "</script>", "<!--", "$(x)"),
    *(
        ">= 1",
        "< nan",
        ">= 1e999",
        "== =",
        "!= ",
        "X",
        "_",
        "f(X)",
        ".print(1)",
        "a:b",
        "os:getcwd",
    ),
    *("ariac2023", "paper", "external", "parked", "helpful", "a" * 5000 + ".asl", "pi/0", "-pi/2"),
)
ODD_STRUCTURES: tuple[Any, ...] = ([], {}, [[]], [{}], {"": None}, [None], [0.0, 0.0], [1e308] * 3)


def damaged_tree(tree: Any, draw: Random) -> Any:
    """A copy of `tree` (dicts, lists, scalars) with one damage."""
    tree = copy.deepcopy(tree)
    places = list(_places(tree))
    if not places:
        return _odd(draw, tree)
    parent, key = draw.choice(places)
    value = parent[key]
    kind = draw.randrange(12)
    if kind == 0:
        del parent[key]
    elif kind == 1:
        parent[key] = _odd(draw, tree)
    elif kind == 2:
        parent[key] = _like(value, draw)
    elif kind == 3:
        other, there = draw.choice(places)
        parent[key] = copy.deepcopy(other[there])
    elif kind == 4:
        parent[key] = [value] * draw.choice((1, 2, 3, 50))
    elif kind == 5:
        parent[key] = {draw.choice(("x", "time", str(key))): value}
    elif kind == 6 and isinstance(value, list | dict) and value:
        inner = list(value.values()) if isinstance(value, dict) else value
        parent[key] = draw.choice(inner)
    elif kind == 7:
        _repeat(parent, key, draw)
    elif kind == 8 and isinstance(parent, dict):
        parent[_other_key(tree, str(key), draw)] = parent.pop(key)
    elif kind == 9 and isinstance(parent, dict):
        parent[_other_key(tree, str(key), draw)] = _odd(draw, tree)
    elif kind == 10 and isinstance(parent, list):
        draw.shuffle(parent)
    else:
        parent[key] = _like(value, draw)
    return tree


def as_json(tree: Any, draw: Random) -> bytes:
    """`tree` as JSON, some of what only Python takes for JSON with it."""
    text = json.dumps(tree, ensure_ascii=draw.random() < 0.5)
    return _deep(text, draw).encode("utf-8", "surrogatepass")


def as_yaml(tree: Any, draw: Random) -> bytes:
    """`tree` as YAML: one line for each of its keys and items."""
    lines = []
    if isinstance(tree, dict) and tree:
        for key, value in tree.items():
            if isinstance(value, list) and value and draw.random() < 0.5:
                lines += [f"{_flow(key)}:", *(f"  - {_flow(one)}" for one in value)]
            else:
                lines.append(f"{_flow(key)}: {_flow(value)}")
    else:
        lines.append(_flow(tree))
    text = _deep("\n".join(lines) + "\n", draw)
    return text.encode("utf-8", "surrogatepass")


def _places(tree: Any) -> Any:
    """The parent and key of every value within `tree`."""
    pending = [tree]
    while pending:
        node = pending.pop()
        if not isinstance(node, dict | list):
            continue
        for key in list(node) if isinstance(node, dict) else range(len(node)):
            yield node, key
            pending.append(node[key])


def _odd(draw: Random, tree: Any) -> Any:
    kind = draw.randrange(8)
    if kind < 3:
        return draw.choice(ODD_NUMBERS)
    if kind < 6:
        return draw.choice(ODD_TEXTS)
    if kind == 6:
        return copy.deepcopy(draw.choice(ODD_STRUCTURES))
    return (
        DEEP if draw.random() < 0.2 else [draw.uniform(-20, 20) for _ in range(draw.randint(0, 5))]
    )


def _like(value: Any, draw: Random) -> Any:
    """Something of the kind of `value`, or nearly."""
    if isinstance(value, bool):
        return draw.choice((not value, 0, 1, "yes"))
    if isinstance(value, int | float):
        if abs(value) > 1e15 or value != value:
            return draw.choice(ODD_NUMBERS)
        near = (value + 1, -value, value * 1e3, value + 1e-9, float(value), str(value), int(value))
        return draw.choice((*near, draw.uniform(-25, 25), *ODD_NUMBERS))
    if isinstance(value, str):
        at = draw.randint(0, len(value))
        odd = draw.choice(ODD_TEXTS)
        return draw.choice((odd, value[:at] + odd + value[at:], value[:at], value * 2, [value]))
    return draw.choice((None, [], {}, 0, "x"))


def _repeat(parent: Any, key: Any, draw: Random) -> None:
    count = draw.choice((2, 3, 40, 400))
    if isinstance(parent, list):
        parent[key:key] = [copy.deepcopy(parent[key])] * count
    else:
        for k in range(count):
            parent[f"{key}{k}"] = parent[key]


def _other_key(tree: Any, key: str, draw: Random) -> str:
    keys = [str(k) for parent, k in _places(tree) if isinstance(parent, dict)]
    return draw.choice((*keys, key[:-1], key + "x", key.upper(), draw.choice(ODD_TEXTS)))


def _flow(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_flow(key)}: {_flow(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_flow, value)) + "]"
    if isinstance(value, float):
        if not math.isfinite(value):
            return ".nan" if value != value else ".inf" if value > 0 else "-.inf"
        text = repr(value)
        return text if "." in text or "e" not in text else text.replace("e", ".0e")
    if isinstance(value, str) and value != DEEP and value.isidentifier():
        return value
    return json.dumps(value, ensure_ascii=False, default=str)


def _deep(text: str, draw: Random) -> str:
    depth = draw.choice((50, 400, 3000, 100_000))
    opened, closed = draw.choice((("[", "]"), ('{"a": ', "}")))
    return text.replace(f'"{DEEP}"', opened * depth + "1" + closed * depth)
