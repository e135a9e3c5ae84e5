"""The nearest that two of many discs come is what the monitor finds pair by pair."""

import itertools

import numpy as np
import pytest

import navigation
from navigation.measures import nearest_pair


def wandering(
    rng: np.random.Generator, width: float, jumps: bool, length: float
) -> navigation.Motion:
    """A walk on a square floor, in the middle of which somebody may be put elsewhere."""
    late = length / 10
    walks = [
        navigation.walk(rng.uniform(0, width, (4, 2)), begin + rng.uniform(0, late), max_speed=1.5)
        for begin in ((0.0, length / 2) if jumps else (0.0,))
    ]
    return navigation.join(walks)


@pytest.mark.parametrize("jumps", [False, True])
@pytest.mark.parametrize("width", [6.0, 60.0])
@pytest.mark.parametrize("length", [20.0, 300.0])
def test_nearest_pair_sees_what_an_oracle_sees(length, width, jumps):
    rng = np.random.default_rng(7)
    for _ in range(20):
        count = int(rng.integers(2, 8))
        motions = [wandering(rng, width, jumps, length) for _ in range(count)]
        radii = rng.uniform(0.1, 0.4, count)
        found = nearest_pair(motions, list(radii), [1.5] * count, 0.0, length)
        apart = {
            (i, j): navigation.minimum_separation(motions[i], motions[j], 0.0, length)[1]
            - radii[i]
            - radii[j]
            for i, j in itertools.combinations(range(count), 2)
        }
        if min(apart.values()) >= 0:
            assert found.distance == pytest.approx(min(apart.values()), abs=1e-8)
            assert apart[found.pair] == pytest.approx(found.distance, abs=1e-8)
        assert found.overlaps == sum(gap < -1e-9 for gap in apart.values())


def test_those_who_are_not_there_are_near_nobody():
    rng = np.random.default_rng(8)
    together = 0
    for _ in range(40):
        count = int(rng.integers(2, 6))
        motions = [wandering(rng, 6.0, jumps=True, length=20.0) for _ in range(count)]
        spans = [tuple(np.sort(rng.uniform(-5.0, 25.0, 2)).tolist()) for _ in range(count)]
        spans[0] = (9.0, 9.0)
        args = (motions, [0.0] * count, [1.5] * count, 0.0, 20.0)
        found = nearest_pair(*args, spans)
        apart = {}
        for i, j in itertools.combinations(range(count), 2):
            begin, end = max(spans[i][0], spans[j][0], 0.0), min(spans[i][1], spans[j][1], 20.0)
            if begin < end:
                both = navigation.minimum_separation(motions[i], motions[j], begin, end)
                apart[i, j] = both[1]
        together += bool(apart)
        if not apart:
            assert found is None
            continue
        assert found.distance == pytest.approx(min(apart.values()), abs=1e-6)
        assert apart[found.pair] == pytest.approx(found.distance, abs=1e-6)
    assert 5 < together < 40
