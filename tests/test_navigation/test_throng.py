"""A throng as one of it sees the others, and the segments along which there is room."""

import math

import shapely

import navigation
from navigation.freespace import Walls
from navigation.kernels.edges import Legs
from navigation.kernels.numbers import numbers
from navigation.kernels.throng import Throng
from navigation.walking import swath as swath_of

NOW, GAP, RADIUS = 3.0, 0.006, 0.3
NOWHERE = (False, math.inf, math.inf)


def throng(*motions: navigation.Motion) -> Throng:
    """Return discs that are committed to these motions from `NOW` on, bound for nowhere."""
    made = Throng(GAP)
    for motion in motions:
        swath = swath_of(motion, NOW)
        made.add(swath.table, swath.box, RADIUS)
    return made


def standing(*places: tuple[float, float]) -> Throng:
    return throng(*(navigation.standing(place) for place in places))


def test_directions_are_those_of_velocities_or_else_of_routes():
    east = navigation.walk([(0.0, 0.0), (9.0, 0.0)], NOW - 1.0)
    seen = throng(east, navigation.standing((5.0, 5.0)), navigation.standing((1.0, 1.0)))
    seen.send(0, True, 0.0, 9.0)
    seen.send(1, True, 8.0, 9.0)
    assert seen.between(0, 1, NOW) == 0.6
    assert seen.between(1, 0, NOW) == 0.6
    # Who has come to the end of their walk would go on by their route.
    assert math.isclose(seen.between(0, 1, east.end), (0.8 - 0.6) / math.sqrt(2))
    assert seen.between(0, 2, NOW) == 0.0
    seen.send(1, *NOWHERE)
    assert seen.between(0, 1, NOW) == 0.0


def test_who_stands_around_is_told_with_how_far_to_stay():
    later = navigation.walk([(1.0, 0.0), (1.0, 5.0)], NOW)
    seen = throng(navigation.standing((0.0, 0.0)), navigation.standing((2.0, 0.0)), later)
    near = numbers([0.0, 0.0, 0.0, 0.0])
    assert [*seen.standing(0, near, 3.0, NOW)] == [2.0, 0.0, RADIUS + RADIUS + GAP]
    assert [*seen.standing(0, near, 0.5, NOW)] == []
    assert [*seen.standing(1, near, 3.0, later.end)] == [
        *(0.0, 0.0, RADIUS + RADIUS + GAP),
        *(1.0, 5.0, RADIUS + RADIUS + GAP),
    ]


def test_a_ring_grows_through_gaps_that_are_too_narrow():
    # From the goal at 0, 0 by two to the third; the fourth leaves a gap to them.
    seen = standing((9.0, 9.0), (0.2, 0.0), (1.3, 0.0), (2.4, 0.0), (4.0, 0.0))
    around = [k for k in range(1, 5) if seen.encloses(0, k, 0.0, 0.0, 6.0, NOW)]
    assert around == [1, 2, 3]


def test_segments_are_free_of_walls_and_of_what_is_asked_about():
    asked = []

    def ask(a: tuple[float, float], b: tuple[float, float]) -> bool:
        asked.append((a, b))
        return False

    legs = Legs(Walls(shapely.box(0.0, 0.0, 9.0, 9.0), RADIUS).grid, RADIUS, ask)
    legs.bounds = numbers([4.0, 4.0, 5.0, 5.0])
    assert legs.free(1.0, 1.0, 8.0, 1.0) and not legs.free(1.0, 1.0, 8.8, 1.0)
    assert not asked
    assert not legs.free(1.0, 4.5, 8.0, 4.5)
    assert asked == [((1.0, 4.5), (8.0, 4.5))]
    assert legs.farthest(1.0, 1.0, [(1.0, 2.0), (1.0, 8.0), (8.0, 8.0)]) == 1
    assert legs.farthest(1.0, 1.0, [(9.0, 1.0)]) == -1
