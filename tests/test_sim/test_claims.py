"""Claims of machines: they contain the swept areas, and never meet each other."""

import math
import random

import numpy as np
import pytest
import shapely
from test_traffic import random_trial

import navigation
import sim
from sim.machines.traffic.areas import CLEAR, Area, Footprint
from sim.machines.traffic.waiting import circle_of, leads_to

SHAPE = sim.MachineShape(
    name="cart", kind="amr", category="vehicle", length=1.6, width=0.8, top=0.4, top_speed=1.5
)
LIMITS = navigation.VehicleLimits(side_speed=0.8)


def random_motion(draw):
    """Return a motion of turns and drives, or one that drives and turns at the same time."""
    if draw.random() < 0.5:
        turn, reach = draw.uniform(-6, 6), draw.uniform(0.1, 6)
        there = reach * math.cos(turn), reach * math.sin(turn)
        poses = [(0.0, 0.0, turn), (*there, turn), (*there, turn - draw.uniform(0.1, 3))]
        return navigation.vehicle_path((0.0, 0.0, 0.0), poses, limits=LIMITS)
    twist = draw.uniform(-1.5, 1.5), draw.uniform(-0.8, 0.8), draw.uniform(-1, 1)
    seconds = draw.uniform(0.5, 5)
    return navigation.vehicle_twist((0.0, 0.0, 0.3), twist, seconds=seconds, limits=LIMITS)


@pytest.mark.parametrize("seed", range(20))
def test_swept_areas_contain_the_footprint_at_every_time(seed):
    draw = random.Random(seed)
    motion = random_motion(draw)
    begin, end = sorted(draw.uniform(0.0, motion.end) for _ in range(2))
    area = shapely.union_all(Footprint(SHAPE, CLEAR).swept(motion, begin, end).parts)
    for t in np.linspace(begin, end, 200):
        state = motion.state(float(t))
        assert area.covers(SHAPE.footprint(state.at, state.position[2]))


@pytest.mark.parametrize("turn", [0.3, -1.5, 5.0])
def test_a_turn_on_the_spot_sweeps_little_more_than_the_footprint(turn):
    motion = navigation.vehicle_turn((1.0, 2.0, 0.4), 0.4 + turn)
    area = shapely.union_all(Footprint(SHAPE, 0.0).swept(motion, 0.0, motion.end).parts)
    angles = 0.4 + turn * np.linspace(0.0, 1.0, round(250 * abs(turn)))
    covered = shapely.union_all([SHAPE.footprint((1.0, 2.0), float(angle)) for angle in angles])
    assert area.within(shapely.buffer(covered, 2e-3))


def test_areas_meet_where_they_have_a_point_in_common():
    footprint = Footprint(SHAPE, 0.0)
    here = footprint.at((0.0, 0.0, 0.0))
    assert here.meets(footprint.at((1.55, 0.0, 0.0)))
    assert not here.meets(footprint.at((1.7, 0.0, 0.0)))
    assert here.gap(footprint.at((4.0, 0.0, 0.0))) == pytest.approx(2.4, abs=0.02)
    both = Area.of([here, footprint.at((4.0, 0.0, 0.0))])
    assert both.meets(footprint.at((4.0, 0.5, 1.0))) and len(both.parts) == 2


def test_claims_never_meet_and_contain_the_machines():
    simulation = sim.Simulation(random_trial(1, 600.0))
    claimants = simulation._traffic._claimants
    for t in np.arange(0.0, 120.0, 0.5):
        simulation.advance(float(t))
        for k, one in enumerate(claimants):
            state = one.machine.body.state
            claim = shapely.union_all(one.claim.parts)
            assert claim.covers(one.machine.shape.footprint(state.at, state.position[2]))
            assert not any(one.claim.meets(other.claim) for other in claimants[:k])


def test_circles_of_machines_that_wait_for_each_other():
    waits_for = {"a": ["x", "b"], "b": ["c"], "c": ["a"], "d": ["a"], "e": ["x"]}
    assert circle_of("a", waits_for) == ("a", "b", "c")
    assert circle_of("d", waits_for) == circle_of("e", waits_for) == ()
    assert leads_to("d", ("b", "c"), waits_for) and not leads_to("e", ("b", "c"), waits_for)
