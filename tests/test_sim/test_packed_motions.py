"""Motions packed for the page of a long run: what is unpacked is what was packed."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, strategies as st

from sim.views.replay import BLOCK, pack, unpack

number = st.floats(-999, 999).map(lambda value: round(value, 9) + 0.0)
cubic = st.lists(number | st.just(0.0), min_size=1, max_size=4)
piece = st.tuples(st.floats(0, 1), st.floats(0, 5), st.booleans(), cubic, cubic, cubic)


@st.composite
def motion(draw):
    """Pieces in order, some of which go on where the one before ends, as those of a walk do."""
    pieces, t = [], draw(number)
    for gap, duration, goes_on, *axes in draw(st.lists(piece, min_size=1, max_size=6)):
        begin = t if goes_on else round(t + gap, 9)
        if pieces and goes_on:
            axes = [
                [round(c, 9) + 0.0, *axis[1:]]
                for c, axis in zip(_end(pieces[-1]), axes, strict=True)
            ]
        t = round(begin + duration, 9)
        pieces.append([begin, t, *axes])
    return pieces


def _end(piece):
    """The place and heading in which a piece ends."""
    begin, end, *axes = piece
    return [sum(c * (end - begin) ** n for n, c in enumerate(axis)) for axis in axes]


def _jumps(pieces):
    return [
        k
        for k in range(1, len(pieces))
        if math.dist(_end(pieces[k - 1])[:2], [axis[0] for axis in pieces[k][2:4]]) > 1e-6
    ]


@given(st.dictionaries(st.text(max_size=5), motion(), max_size=3))
def test_what_is_unpacked_is_what_was_packed(motions):
    index, blocks = pack(motions)
    assert unpack(index, blocks) == motions
    assert {name: body["jumps"] for name, body in index.items()} == {
        name: _jumps(pieces) for name, pieces in motions.items()
    }


def test_of_many_pieces_each_block_can_be_read_alone():
    pieces, x = [], 0.0
    for k in range(3 * BLOCK - 7):
        pieces.append([k * 0.5, k * 0.5 + 0.5, [x, 1.0, 0.25], [k % 9 * 1.0], [0.0, 0.1]])
        x += 0.5 + 0.0625
    index, blocks = pack({"other": pieces[:3], "body": pieces})
    assert unpack(index, blocks) == {"other": pieces[:3], "body": pieces}
    body = index["body"]
    assert [begin for begin, *_ in body["blocks"]] == [0.0, BLOCK / 2, float(BLOCK)]
    assert [gone for _, gone, *_ in body["blocks"]] == pytest.approx(
        [0.0, BLOCK * 0.5625, 2 * BLOCK * 0.5625], abs=1e-3
    )
    for k, (_, _, at, size) in enumerate(body["blocks"]):
        count = len(pieces[BLOCK * k : BLOCK * (k + 1)])
        alone = {"count": count, "blocks": [[0.0, 0.0, 0, size]]}
        assert (
            unpack({"body": alone}, blocks[at : at + size])["body"]
            == (pieces[BLOCK * k : BLOCK * (k + 1)])
        )


@pytest.mark.parametrize(
    "piece",
    [
        [0.0, 1 / 3, [0.0], [0.0], [0.0]],
        [0.0, 1.0, [1e7], [0.0], [0.0]],
        [0.0, 1.0, [0.0, 0.0, 0.0, 2e6], [0.0], [0.0]],
        [0.0, 5000.0, [0.0, 2e3], [0.0], [0.0]],
        [0.0, 1.0, [0.0] * 5, [0.0], [0.0]],
        [0.0, 1.0, [], [0.0], [0.0]],
        [0.0, 1.0, ["a"], [0.0], [0.0]],
        [0.0, 1.0, 2.0],
        None,
    ],
)
def test_numbers_of_another_form_are_not_packed(piece):
    assert pack({"body": [[0.0, 0.0, [0.0], [0.0], [0.0]], piece]}) is None


def test_damaged_blocks_are_refused():
    index, blocks = pack({"body": [[0.0, 1.0, [k * 1.0, 1.0], [0.0], [0.0]] for k in range(9)]})
    for damaged in (blocks[:-3], b"", b"\xff" * len(blocks)):
        with pytest.raises(ValueError, match="motions can't be read"):
            unpack(index, damaged)
    for wrong in ({"body": {}}, {"body": 3}, {"body": {"count": 2, "blocks": [[1]]}}):
        with pytest.raises(ValueError, match="motions can't be read"):
            unpack(wrong, blocks)
