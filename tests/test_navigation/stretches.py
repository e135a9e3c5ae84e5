"""Comparison of the monitor with dense sampling, and encounters by stretch."""

import numpy as np

from navigation import Encounter


def encounters(human, robot, begin, end, gauges=()):
    """Yield an encounter at each of its stretches from `begin` to `end`, one if they are equal."""
    encounter = Encounter(human, robot, gauges)
    encounter.come_to(begin)
    while encounter.next_stretch(end):
        yield encounter


def part_of(encounter, low, high):
    """Return begin and end of a part of the stretch between two shares, in any order."""
    length = encounter.end - encounter.begin
    return tuple(encounter.begin + length * share for share in (min(low, high), max(low, high)))


def assert_bounds(encounter, begin, end, slope, curve, distances):
    """Assert that bounds on distances minus a parabola hold at times with `distances`."""
    near, far, candidate = encounter.apart(begin, end, slope, curve)
    assert begin <= candidate <= end
    ts = np.linspace(begin, end, 9)
    u = ts - (begin + end) / 2
    exact = distances(ts) - slope * u - curve * u * u / 2
    assert near <= exact.min() + 1e-9
    assert far >= exact.max() - 1e-9


def assert_negative_within(found, ts, margins, end):
    """Assert that margins at `ts` (from 0 to `end`) are negative in the intervals `found` only."""
    inside = np.zeros(len(ts), dtype=bool)
    for since, until in found:
        assert 0.0 <= since <= until <= end
        inside |= (ts >= since) & (ts <= until)
    assert inside[margins < -1e-6].all()
    assert not inside[margins > 1e-6].any()
