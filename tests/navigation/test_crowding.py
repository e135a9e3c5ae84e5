"""The nearest that two of many discs come is what the monitor finds pair by pair."""

import itertools

import numpy as np
import pytest

import navigation


def wandering(rng: np.random.Generator, width: float, jumps: bool) -> navigation.Motion:
    """A walk on a square floor, in the middle of which somebody may be put elsewhere."""
    walks = [
        navigation.walk(rng.uniform(0, width, (4, 2)), begin + rng.uniform(0, 2), max_speed=1.5)
        for begin in ((0.0, 10.0) if jumps else (0.0,))
    ]
    return navigation.join(walks)


@pytest.mark.parametrize("jumps", [False, True])
@pytest.mark.parametrize("width", [6.0, 60.0])
def test_nearest_pair_sees_what_an_oracle_sees(width, jumps):
    rng = np.random.default_rng(7)
    for _ in range(20):
        count = int(rng.integers(2, 8))
        motions = [wandering(rng, width, jumps) for _ in range(count)]
        radii = rng.uniform(0.1, 0.4, count)
        found = navigation.nearest_pair(motions, list(radii), [1.5] * count, 0.0, 20.0)
        apart = {
            (i, j): navigation.minimum_separation(motions[i], motions[j], 0.0, 20.0)[1]
            - radii[i]
            - radii[j]
            for i, j in itertools.combinations(range(count), 2)
        }
        if min(apart.values()) >= 0:
            assert found.distance == pytest.approx(min(apart.values()), abs=1e-8)
            assert apart[found.pair] == pytest.approx(found.distance, abs=1e-8)
        assert found.overlaps == sum(gap < -1e-9 for gap in apart.values())
