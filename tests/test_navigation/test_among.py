"""Paths among bodies with known motions."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from plane_oracle import floor
from shapely.geometry import box

from navigation import (
    Box,
    CollisionWorld,
    Mover,
    PathPlanner,
    PlanningError,
    join,
    plan_among,
    standing,
    walk,
)

RADIUS, GAP = 0.3, 0.1
SOLID = Box(length=1.2, width=0.8, top=1.0)


def drive(points, start=0.0, speed=1.5):
    return walk(points, start, max_speed=speed, max_acceleration=1.0)


def clear(person, machine, begin, end):
    """Return the minimum distance between the surfaces, sampled every 5 ms."""
    t = np.arange(begin, end, 0.005)
    at, turned = machine.position(t), machine.rotation(t)
    away = person.position(t) - at
    along = np.abs(away[:, 0] * np.cos(turned) + away[:, 1] * np.sin(turned))
    across = np.abs(away[:, 1] * np.cos(turned) - away[:, 0] * np.sin(turned))
    beside = np.maximum(along - SOLID.length / 2, 0), np.maximum(across - SOLID.width / 2, 0)
    return float(np.hypot(*beside).min()) - RADIUS


@settings(max_examples=settings.default.max_examples // 4)
@given(
    st.lists(
        st.tuples(st.floats(3, 7), st.floats(-3, 3), st.floats(0, 8), st.floats(0.5, 2.0)),
        min_size=1,
        max_size=3,
    )
)
def test_a_passage_touches_nothing_and_waits_no_longer_than_necessary(vehicles):
    planner = PathPlanner(CollisionWorld(floor()), RADIUS)
    moving = [
        Mover(f"v{k}", drive([(x, 0.7), (x + slant, 9.3)], t, speed), SOLID)
        for k, (x, slant, t, speed) in enumerate(vehicles)
    ]
    moving = [one for one in moving if 0.7 < one.motion.position(one.motion.end)[0] < 9.3]
    start, goal = (1.0, 5.0), (9.0, 5.0)
    passage = plan_among(planner, start, goal, moving)
    assert tuple(passage.motion.position(0.0)) == start
    assert tuple(passage.motion.position(passage.arrives)) == pytest.approx(goal)
    for mover in moving:
        assert clear(passage.motion, mover.motion, 0.0, passage.arrives) >= GAP - 1e-3
    straight = walk([start, goal])
    for delay in np.arange(0.0, passage.arrives - straight.end - 0.01, 0.05):
        later = join([standing(start), walk([start, goal], delay)])
        assert any(clear(later, m.motion, 0.0, later.end) < GAP + 1e-2 for m in moving)


def test_a_person_waits_or_takes_a_detour_whichever_is_faster():
    wall = [box(4.0, 0.0, 5.0, 3.0), box(4.0, 4.5, 5.0, 7.0), box(4.0, 8.5, 5.0, 10.0)]
    planner = PathPlanner(CollisionWorld(floor(*wall)), RADIUS)
    start, goal = (2.5, 3.75), (6.5, 3.75)
    free = plan_among(planner, start, goal, [])
    assert free.arrives == pytest.approx(walk([start, goal]).end)
    through = Mover("cart", drive([(4.5, 3.75), (4.5, 3.75 + 1e-9), (8.5, 3.75 + 1e-9)]), SOLID)
    comes = Mover("cart", drive([(8.0, 3.75), (4.5, 3.75)], speed=0.6), SOLID)
    waits = plan_among(planner, start, (6.5, 5.5), [through])
    assert clear(waits.motion, through.motion, 0.0, waits.arrives) >= GAP - 1e-3
    round_it = plan_among(planner, start, goal, [comes], at=1.0)
    assert not round_it.waits
    assert round_it.path.points[:, 1].max() > 6.5
    assert clear(round_it.motion, comes.motion, 1.0, round_it.arrives) >= GAP - 1e-3


def test_a_moving_body_in_the_world_counts_at_its_future_places():
    world = CollisionWorld(floor(box(4.0, 0.0, 5.0, 4.0), box(4.0, 6.0, 5.0, 10.0)))
    world.place("cart", box(3.9, 4.4, 5.1, 5.6))
    planner = PathPlanner(world, RADIUS)
    with pytest.raises(PlanningError):
        planner.plan((2.0, 5.0), (7.0, 5.0))
    leaves = Mover("cart", drive([(4.5, 5.0), (9.0, 5.0), (9.0, 9.0)]), SOLID)
    passage = plan_among(planner, (2.0, 5.0), (7.0, 5.0), [leaves])
    assert clear(passage.motion, leaves.motion, 0.0, passage.arrives) >= GAP - 1e-3
    assert "cart" in {body.name for body in world.bodies}


def test_a_missing_passage_is_reported_with_its_reason():
    planner = PathPlanner(CollisionWorld(floor(box(4, -1, 6, 11))), RADIUS)
    with pytest.raises(PlanningError) as cut:
        plan_among(planner, (2.0, 5.0), (8.0, 5.0), [])
    assert cut.value.reason == "unreachable"
    planner = PathPlanner(CollisionWorld(floor()), RADIUS)
    parks = Mover("cart", drive([(8.0, 1.0), (8.0, 5.0)]), SOLID)
    with pytest.raises(PlanningError, match="among cart with at most 5 s to wait") as parked:
        plan_among(planner, (2.0, 5.0), (8.0, 5.0), [parks], at=3.0, patience=5.0)
    assert parked.value.reason == "not_found"


def test_a_person_arrives_before_a_vehicle_parks_on_the_goal():
    planner = PathPlanner(CollisionWorld(floor()), RADIUS)
    parks = Mover("cart", drive([(8.0, 1.0), (8.0, 5.0)], 20.0), SOLID)
    passage = plan_among(planner, (2.0, 5.0), (8.0, 5.0), [parks])
    assert passage.arrives == walk([(2.0, 5.0), (8.0, 5.0)]).end
    assert not passage.waits


def test_a_brief_wait_is_preferred_to_a_detour():
    planner = PathPlanner(CollisionWorld(floor()), RADIUS)
    crosses = Mover("cart", drive([(5.0, 3.0), (5.0, 9.0)], speed=2.0), SOLID)
    passage = plan_among(planner, (3.0, 5.0), (8.0, 5.0), [crosses])
    ((_, wait),) = passage.waits
    assert 0.0 < wait <= 1.0
    assert np.allclose(passage.path.points[:, 1], 5.0)
    assert clear(passage.motion, crosses.motion, 0.0, passage.arrives) >= GAP - 1e-3


def test_a_person_who_starts_too_close_to_a_body_comes_no_closer():
    stands = join([standing((5.0, 5.0)), drive([(5.0, 5.0), (8.5, 5.0)], 8.0)])
    planner = PathPlanner(CollisionWorld(floor()), RADIUS)
    passage = plan_among(planner, (4.8, 4.4), (5.0, 7.0), [Mover("v", stands, SOLID)])
    begun = clear(passage.motion, stands, 0.0, 0.005)
    assert -RADIUS < begun < 0.0
    assert clear(passage.motion, stands, 0.0, passage.arrives) > begun - 0.002
