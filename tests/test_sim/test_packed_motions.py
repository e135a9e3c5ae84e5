"""Motions packed for the page of a long run, and unpacked again."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, strategies as st
from replay_sample import replay

number = st.floats(-999, 999)
cubic = st.tuples(st.lists(number, max_size=3), st.floats(0.1, 9)).map(lambda c: [*c[0], c[1]])
piece = st.tuples(number, number, *[cubic | st.just([0.0])] * 3).map(list)


@given(st.dictionaries(st.text(max_size=5), st.lists(piece, min_size=1, max_size=6), max_size=3))
def test_unpacked_motions_equal_the_packed_ones(motions):
    index, blocks = replay.pack(motions)
    assert replay.unpack(index, blocks) == motions


def test_blocks_are_in_the_order_of_time():
    pieces = [
        [k * 0.5, k * 0.5 + 0.5, [k, 1.0, 0.25], [0.0], [0.0]] for k in range(3 * replay.BLOCK - 7)
    ]
    index, blocks = replay.pack({"other": pieces[3:9], "body": pieces})
    assert replay.unpack(index, blocks) == {"other": pieces[3:9], "body": pieces}
    size = 8 * 14 * replay.BLOCK
    assert index["other"]["blocks"] == [size]
    assert index["body"]["blocks"] == [0, size + 8 * 14 * 6, 2 * size + 8 * 14 * 6]


@pytest.mark.parametrize(
    "piece",
    [
        [0.0, math.nan, [0.0], [0.0], [0.0]],
        [0.0, 1.0, [math.inf], [0.0], [0.0]],
        [0.0, 1.0, [0.0] * 5, [0.0], [0.0]],
        [0.0, 1.0, [0.0] * 5, [0.0] * 3, [0.0]],
        [0.0, 1.0, [], [0.0], [0.0]],
        [0.0, 1.0, [0.0], [0.0]],
        [0.0, 1.0, ["a"], [0.0], [0.0]],
        [0.0, 1.0, 2.0],
        None,
    ],
)
def test_pieces_of_another_form_are_not_packed(piece):
    assert replay.pack({"body": [[0.0, 0.0, [0.0], [0.0], [0.0]], piece]}) is None


def test_damaged_blocks_are_rejected():
    index, blocks = replay.pack(
        {"body": [[0.0, 1.0, [k * 1.0, 1.0], [0.0], [0.0]] for k in range(9)]}
    )
    for damaged in (blocks[:-3], b""):
        with pytest.raises(ValueError, match="motions can't be read"):
            replay.unpack(index, damaged)
    for wrong in ({"body": {}}, {"body": 3}, {"body": {"count": 2, "blocks": [[1]]}}):
        with pytest.raises(ValueError, match="motions can't be read"):
            replay.unpack(wrong, blocks)
