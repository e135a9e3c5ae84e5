"""Hypothesis strategies of damaged files: damages to their values and to their bytes."""

import copy
import json
import math
import re

import yaml
from hypothesis import strategies as st

NUMBERS = (
    *(0, 1, -1, 2, 7, 3.5, -0.0, 1e-12, 5e-324, 255, 256, 1e6, -1e6, 1e9, 2**31, 2**63, 2**64),
    *(10**30, 10**400, 1e155, 1e308, -1e308, math.nan, math.inf, -math.inf),
)
TEXTS = (
    *("", " ", "a", "X", "_", "x" * 300, "x" * 20_000, "é", "\U0001f600", "\x00", "\x1b[31m", "\t"),
    *("\u2028", "\ufeff", "a\nb", "../x", "../../etc/passwd", "/", ".", "~", "</script>", "<!--"),
    *("null", "true", "yes", "1e3", "nan", ".inf", "0x10", "1:30", "2023-01-01", "=", "<<", "*"),
    *("&a", "!!int", "%", "{}", "[]", "'", '"', "\\", ">= 1", "< nan", ">= 1e999", "== =", "f(X)"),
    *(".print(1)", "a:b", "os:getcwd", "ariac2023", "paper", "external", "helpful", "pi/0"),
)
SIGNS = (
    *("(", ")", "[", "]", "{", "}", ",", ";", ".", ":", ":-", "<-", "&", "|", "|&|", "|||", "not "),
    *("+", "-", "-+", "++", "!", "!!", "?", "+!", "-!", "@", "~", "=", "==", "\\==", "=..", "<"),
    *("*", "/", "**", " div ", " mod ", "Self", "true", "false", "[source(self)]", "//", "\n"),
    *("if (true) {", "} else {", "while (", "for (", '{ include("other.asl") }', ".print", ".wait"),
    *(".findall", ".range", ".concat", ".nth", ".substring", ".add_plan", ".send", ".fork"),
)
BYTES = (
    *(b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\xed\xa0\x80", b"\r", b"\t", b"\n", b" ", b"---\n"),
    *(b"[" * 60, b"{" * 60, b"]", b"}", b'"', b"'", b"\\", b":", b",", b"#", b"&a", b"*a", b"<<:"),
    *(
        b"NaN",
        b"Infinity",
        b"1e999",
        b"9" * 400,
        b"-",
        b"0",
        b".nan",
        b"null",
        b"!!bool ",
        b"EMPTY",
    ),
)
WORD = re.compile(r'"(?:[^"\\\n]|\\.)*"|\.?\w[\w.]*|\s+|[-+<>=:&|!*/]+|.', re.S)

numbers = st.sampled_from(NUMBERS) | st.floats() | st.integers()
texts = st.sampled_from(TEXTS) | st.text(max_size=5)
values = st.recursive(
    numbers | texts | st.sampled_from((True, False, None)),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=6,
)


def damaged(sample, kind):
    """Strategy of damaged bytes of `sample`, a file with the suffix `kind`, and of any text."""
    of_bytes = edited(sample, st.sampled_from(BYTES) | st.binary(min_size=1, max_size=3))
    if kind == ".yaml":
        tree = trees(yaml.safe_load(sample))
        of_kind = tree.map(lambda one: yaml.safe_dump(one, allow_unicode=True).encode())
    elif kind == ".json":
        of_kind = lines(json.loads(sample))
    elif kind == ".jsonl":
        rows = sample.splitlines()
        row = st.sampled_from(rows).flatmap(lambda one: lines(json.loads(one)))
        of_kind = edited(rows, row.map(lambda one: [one])).map(b"\n".join)
    elif kind in (".png", ".db3", ".h5", ".mcap", ".parquet", ".sqlite"):
        return of_bytes
    else:
        word = st.sampled_from(SIGNS) | numbers.map(str) | texts
        of_kind = edited(WORD.findall(sample.decode()), word.map(lambda one: [one])).map(
            lambda words: "".join(words).encode()
        )
    return of_kind | of_kind | of_kind | of_bytes | st.text(max_size=100).map(str.encode)


def lines(value):
    """Strategy of JSON lines: `value` with damages, also in forms that only Python accepts."""
    return trees(value).map(lambda one: json.dumps(one, ensure_ascii=False).encode())


@st.composite
def trees(draw, tree):
    """Strategy of `tree`, of dicts, lists and scalars, with up to three damages."""
    tree = copy.deepcopy(tree)
    for _ in range(draw(st.integers(1, 3))):
        places = list(_places(tree))
        if not places:
            return draw(values)
        node, key = draw(st.sampled_from(places))
        other, there = draw(st.sampled_from(places))
        value = copy.deepcopy(node[key])
        damage = draw(st.sampled_from(("drop", "change", "exchange", "wrap", "repeat", "rename")))
        if damage == "drop":
            del node[key]
        elif damage == "change":
            node[key] = draw(values | _near(value))
        elif damage == "exchange":
            node[key] = copy.deepcopy(other[there])
        elif damage == "wrap":
            node[key] = draw(st.sampled_from(([], [value], [value] * 50, {"x": value})))
        elif damage == "repeat" and isinstance(node, list):
            node[key:key] = [value] * draw(st.sampled_from((1, 2, 400)))
        elif isinstance(node, dict):
            node[draw(st.sampled_from((str(there), f"{key}x")) | texts)] = node.pop(key)
    return tree


def _places(tree):
    """Yield the parent and the key of every value within `tree`."""
    pending = [tree]
    while pending:
        node = pending.pop()
        if isinstance(node, dict | list):
            for key in list(node) if isinstance(node, dict) else range(len(node)):
                yield node, key
                pending.append(node[key])


def _near(value):
    """Return a strategy of values of the same or a similar kind as `value`."""
    if isinstance(value, int | float):
        near = (-value, value + 1, value * 1000, float(value), str(value), not value)
        return st.sampled_from(near) | st.floats(-25, 25)
    if isinstance(value, str):
        return st.sampled_from((value[:-1], value * 2, value.upper())) | texts.map(value.__add__)
    return st.sampled_from((None, [], {}))


@st.composite
def edited(draw, parts, new):
    """Strategy of `parts`, a list or bytes, with up to four runs dropped, replaced, repeated or
    moved.
    """
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(parts)))
        run = parts[at : at + draw(st.sampled_from((0, 1, 1, 2, 5, 30, 400)))]
        before, after = parts[:at], parts[at + len(run) :]
        damage = draw(st.sampled_from(("drop", "replace", "repeat", "move", "nest")))
        if damage == "drop":
            parts = before + after
        elif damage == "replace":
            parts = before + draw(new) + after
        elif damage == "repeat":
            parts = before + run * draw(st.sampled_from((2, 3, 50))) + after
        elif damage == "move":
            there = draw(st.integers(0, len(after)))
            parts = before + after[:there] + run + after[there:]
        else:
            depth = draw(st.sampled_from((1, 2, 30, 500)))
            parts = before + draw(new) * depth + run + draw(new) * depth + after
    return parts
