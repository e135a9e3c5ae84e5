"""Encounters stretch by stretch, as the monitor goes through them."""

from navigation import Encounter


def encounters(human, robot, begin, end, gauges=()):
    """Yield an encounter at each of its stretches from `begin` to `end`; one if they are equal."""
    encounter = Encounter(human, robot, gauges)
    encounter.come_to(begin)
    while encounter.next_stretch(end):
        yield encounter
