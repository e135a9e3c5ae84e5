"""Tracks: what a body did, packed, is what it did."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import navigation
from navigation import Motion
from navigation.motion import Track

point = st.tuples(st.floats(-20, 20), st.floats(-20, 20))
walks = st.lists(st.lists(point, min_size=2, max_size=4), min_size=1, max_size=5)


def one_after_another(walks):
    """Walks as motions, each put where it starts from, the moment the last one ends."""
    motions, t = [], 0.0
    for points in walks:
        motions.append(navigation.walk(points, t).cut(t, t + 30.0))
        t += 30.0
    return motions


def add(track, motion):
    track.add(motion, motion.start, motion.end)


@given(walks)
def test_a_track_is_the_motions_joined(walks):
    motions = one_after_another(walks)
    track = Track()
    for motion in motions:
        add(track, motion)
    whole, joined = track.motion(), navigation.join(motions)
    assert whole == joined
    assert hash(whole) == hash(joined)
    assert whole.jumps == joined.jumps
    ts = np.linspace(-1.0, joined.end + 1.0, 500)
    assert (whole.position(ts) == joined.position(ts)).all()
    assert (whole.velocity(ts) == joined.velocity(ts)).all()
    assert repr([*whole.table]) == repr([c for motion in motions for c in motion.table])  # -0.0 too
    for t in (0.0, 0.7, joined.end / 2, joined.end):
        assert whole.state(t) == joined.state(t)
        assert whole.pieces_from(t) == joined.pieces_from(t)
        assert whole.cut(t, t + 3.0) == joined.cut(t, t + 3.0)
    assert whole.pieces[-1] == joined.pieces[-1]
    assert len(whole.pieces) == len(joined.pieces)


def test_a_track_goes_on_without_changing_what_was_taken_from_it():
    track = Track()
    assert not track
    add(track, navigation.walk([(0, 0), (3, 0)], 0.0))
    early = track.motion()
    add(track, navigation.walk([(3, 0), (5, 0)], early.end))
    assert early.position(100.0)[0] == pytest.approx(3.0)
    assert track.motion().position(100.0)[0] == pytest.approx(5.0)


def test_a_gap_in_a_track_is_refused():
    track = Track()
    add(track, navigation.walk([(0, 0), (3, 0)], 0.0))
    with pytest.raises(ValueError, match="gap"):
        add(track, navigation.standing((3, 0), start=50.0))


def test_pieces_of_a_track_are_a_sequence_of_their_own():
    track = Track()
    add(track, navigation.walk([(0, 0), (3, 0), (3, 5)], 0.0))
    pieces = track.motion().pieces
    assert Motion(tuple(pieces)) == track.motion()
    assert tuple(pieces[1:]) == tuple(pieces)[1:]
    assert pieces != list(pieces)
