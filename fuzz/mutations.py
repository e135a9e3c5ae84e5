"""Damages to files, drawn at random: of bytes, of words, and of what stands in them."""

from __future__ import annotations

import json
import re
from functools import lru_cache
from random import Random
from typing import Any, Literal

from .trees import ODD_NUMBERS, ODD_TEXTS, as_json, as_yaml, damaged_tree

Form = Literal["yaml", "json", "lines", "words", "bytes"]
"""What a file is made of: YAML, JSON, lines of JSON, words and signs, or nothing one knows."""

ODD = (
    *(b"", b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\xed\xa0\x80", b"\r", b"\t", b"\n", b" ", b"%"),
    *(b"[" * 60, b"{" * 60, b"(" * 60, b"]", b"}", b")"),
    *(b"&a", b"*a", b"<<:", b"!!bool ", b"---\n"),
    *(b"-", b"0", b"1e999", b".nan", b".inf", b"-1", b"9" * 400, b"1e-320", b"null", b"~", b"true"),
    *(b"NaN", b"Infinity", b'"', b"'", b"\\", b":", b",", b".", b"#", b"//", b"/*", b"_", b"X"),
    *(b"[source(X)]", b":- ", b"<- ", b"+!", b"-!", b"not ", b'{ include("p.asl") }', b".include("),
    *(b"a" * 300, "é".encode(), "\U0001f600".encode(), b"EMPTY", b"POLYGON", b"../../etc/passwd"),
)
WORD = re.compile(r'"(?:[^"\\\n]|\\.)*"|\.?\w[\w.]*|\s+|[-+<>=:&|!*/]+|.', re.S)
SIGNS = (
    *("(", ")", "[", "]", "{", "}", ",", ";", ".", ":", ":-", "<-", "&", "|", "|&|", "|||", "not "),
    *("+", "-", "-+", "++", "--", "!", "!!", "?", "+!", "-!"),
    *("@", "~", "=", "==", "\\==", "=..", "<"),
    *("*", "/", "**", " div ", " mod ", "_", "X", "Self", "true", "false", "[source(self)]", "//"),
    *("if (true) {", "} else {", "while (", "for (", '{ include("other.asl") }', ".print", ".wait"),
    *(".findall", ".range", ".concat", ".nth", ".substring", ".add_plan", ".send", ".fork", "\n"),
)


def damaged(data: bytes, draw: Random, form: Form = "bytes") -> bytes:
    """`data` with a few damages; `form` says of what kind they can be."""
    if form == "bytes" or draw.random() < 0.2:
        return _bytes(data, draw)
    try:
        data = _DAMAGE[form](data, draw)
    except (ValueError, RecursionError):
        return _bytes(data, draw)
    return _bytes(data, draw, most=2) if draw.random() < 0.1 else data


def _bytes(data: bytes, draw: Random, most: int = 6) -> bytes:
    for _ in range(draw.randint(1, most)):
        at, to = sorted(draw.randint(0, len(data)) for _ in range(2))
        to = min(to, at + draw.choice((1, 3, 10, 40, 400)))
        kind = draw.randrange(6)
        if kind == 0:
            data = data[:at] + data[to:]
        elif kind == 1:
            data = data[:at] + draw.choice(ODD) + data[at:]
        elif kind == 2:
            data = data[:at] + draw.choice(ODD) + data[to:]
        elif kind == 3:
            data = data[:at] + data[at:to] * draw.randint(2, 4) + data[to:]
        elif kind == 4:
            there = draw.randint(0, len(data))
            data = data[:there] + data[at:to] + data[there:]
        elif data:
            at = min(at, len(data) - 1)
            data = data[:at] + bytes([draw.randrange(256)]) + data[at + 1 :]
    return data


def _yaml(data: bytes, draw: Random) -> bytes:
    return as_yaml(_few(_tree(data), draw), draw)


@lru_cache(maxsize=100)
def _tree(data: bytes) -> Any:
    import yaml

    try:
        return yaml.safe_load(data)
    except (yaml.YAMLError, AttributeError, LookupError, TypeError) as why:
        raise ValueError(str(why)) from None


def _json(data: bytes, draw: Random) -> bytes:
    return as_json(_few(json.loads(data), draw), draw)


def _lines(data: bytes, draw: Random) -> bytes:
    lines = data.split(b"\n")
    for _ in range(draw.randint(1, 3)):
        if not lines:
            return b""
        at = draw.randrange(len(lines))
        kind = draw.randrange(8)
        if kind == 0:
            del lines[at]
        elif kind == 1:
            lines.insert(at, draw.choice(lines))
        elif kind == 2:
            draw.shuffle(lines)
        elif lines[at]:
            lines[at] = _json(lines[at], draw)
    return b"\n".join(lines)


def _words(data: bytes, draw: Random) -> bytes:
    words = WORD.findall(data.decode("utf-8"))
    for _ in range(draw.randint(1, 5)):
        if not words:
            break
        at = draw.randrange(len(words))
        to = min(len(words), at + draw.choice((1, 1, 2, 5, 30)))
        kind = draw.randrange(9)
        if kind == 0:
            del words[at:to]
        elif kind == 1:
            words[at:at] = words[at:to] * draw.choice((1, 2, 50))
        elif kind == 2:
            words[at] = draw.choice(words)
        elif kind == 3:
            words[at] = draw.choice(SIGNS)
        elif kind == 4:
            words.insert(at, draw.choice(SIGNS))
        elif kind == 5:
            numbers = [k for k, word in enumerate(words) if word[:1].isdigit()] or [at]
            words[draw.choice(numbers)] = str(draw.choice(ODD_NUMBERS))
        elif kind == 6:
            words[at] = draw.choice(ODD_TEXTS)
        elif kind == 7:
            there = draw.randint(0, len(words))
            words[there:there] = words[at:to]
        else:
            opened, closed = draw.choice(
                (("(", ")"), ("[", "]"), ("f(", ")"), ("{ ", " }"), ("-", ""))
            )
            depth = 20_000 if draw.random() < 0.03 else draw.choice((1, 2, 30, 500))
            words[at:to] = [opened * depth, *words[at:to], closed * depth]
    return "".join(words).encode("utf-8", "surrogatepass")


def _few(tree: Any, draw: Random) -> Any:
    for _ in range(draw.choice((1, 1, 1, 2, 3))):
        tree = damaged_tree(tree, draw)
    return tree


_DAMAGE = {"yaml": _yaml, "json": _json, "lines": _lines, "words": _words, "bytes": _bytes}
