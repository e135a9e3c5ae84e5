"""Small damages to files, drawn at random: what a slip of the hand or a bad disk leaves."""

from __future__ import annotations

from random import Random

ODD = (
    *(b"", b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\xed\xa0\x80", b"\r", b"\t", b"\n", b" ", b"%"),
    *(
        b"[" * 60,
        b"{" * 60,
        b"(" * 60,
        b"]",
        b"}",
        b")",
        b"&a",
        b"*a",
        b"<<:",
        b"!!bool ",
        b"---\n",
    ),
    *(b"-", b"0", b"1e999", b".nan", b".inf", b"-1", b"9" * 400, b"1e-320", b"null", b"~", b"true"),
    *(b"NaN", b"Infinity", b'"', b"'", b"\\", b":", b",", b".", b"#", b"//", b"/*", b"_", b"X"),
    *(b"[source(X)]", b":- ", b"<- ", b"+!", b"-!", b"not ", b'{ include("p.asl") }', b".include("),
    *(b"a" * 300, "é".encode(), "\U0001f600".encode(), b"EMPTY", b"POLYGON", b"../../etc/passwd"),
)


def damaged(data: bytes, draw: Random) -> bytes:
    """`data` with a few damages."""
    for _ in range(draw.randint(1, 6)):
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
