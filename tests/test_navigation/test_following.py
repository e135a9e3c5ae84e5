"""Whom somebody follows who walks on among others, against the definition."""

import math
from itertools import pairwise

import pytest
from hypothesis import given, strategies as st

from navigation import walk
from navigation.kernels.following import followed
from navigation.kernels.numbers import numbers
from navigation.walking import swath

coordinates = st.floats(-3.0, 3.0)
places = st.tuples(coordinates, coordinates)
motions = st.lists(places, min_size=2, max_size=3).filter(
    lambda course: all(math.dist(a, b) > 0.1 for a, b in pairwise(course))
)


@given(
    st.lists(st.tuples(motions, st.floats(0.2, 0.5)), max_size=6),
    st.floats(0.0, 2.0),
    places,
    st.floats(0.0, 2 * math.pi),
)
def test_who_keeps_somebody_slowest_is_followed_unless_somebody_comes(others, t, at, heading):
    c, s = math.cos(heading), math.sin(heading)
    walks = [walk(course, 0.5) for course, _ in others]
    speeds, slow, oncoming = {}, [], False
    for k, (motion, (_, radius)) in enumerate(zip(walks, others, strict=True)):
        state, then = motion.state(t), motion.state(t + 0.5)
        dx, dy = state.at[0] - at[0], state.at[1] - at[1]
        along, beside, touch = dx * c + dy * s, abs(dy * c - dx * s), 0.3 + radius
        if along <= 0.0 or beside >= max(1.5, touch):
            continue
        if state.speed <= 0.05:
            slow.append(k)
            continue
        same = (state.velocity[0] * c + state.velocity[1] * s) / state.speed
        oncoming |= same < -0.7 and beside < 1.5
        if same > 0.7 and beside < touch:
            onward = (then.at[0] - state.at[0]) * c + (then.at[1] - state.at[1]) * s
            room = along - math.sqrt(touch**2 - beside**2) + onward / 0.5
            speeds[k] = room / (1.0 - beside / touch + 1.0)
    found: list[int] = []
    k = followed(
        [*range(len(walks))],
        [swath(motion, 0.0).table for motion in walks],
        numbers(radius for _, radius in others),
        *(t, 0.5, *at, c, s),
        *(0.3, 1.0, 1.0, 1.2, 0.7, 1.5),
        found,
    )
    slowest = min(speeds.values(), default=math.inf)
    if oncoming or slowest >= 1.2:
        assert k == -1
    else:
        assert speeds[k] == pytest.approx(slowest)
    assert found == ([] if oncoming else slow)
