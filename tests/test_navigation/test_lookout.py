"""How long a motion is safe, beside looking at many instants of it and of the stop after it."""

import itertools
import math

import numpy as np
from hypothesis import assume, given, strategies as st

import floorplan
import navigation
from navigation.kernels.lookout import most_remote
from navigation.machines import agv_stops, gantry_stops
from navigation.monitor import StoppingHorizon
from navigation.separation import is_of_speeds, required_at_speeds

LAWS = (
    navigation.SeparationLaw(t1=0.5, t2=1.0, intrusion=0.3),
    navigation.FixedDistance(1.0),
    navigation.IntegralLaw(t1=0.5, t2=1.0),
)
TOP = math.sqrt(2.0)
LANE = floorplan.load("ariac2023").lane("agv1")
MARGIN = 0.01
NOW, LEAST = 3.0, 0.2

near = st.tuples(st.floats(-10, -5), st.floats(0, 6), st.floats(-3, 3))


def lack(motion, begin, end, person, law):
    """Return how many metres are lacking at the worst of many instants."""
    x, y, speed = person
    worst = -math.inf
    for t in np.linspace(begin, end, 60).tolist():
        state = motion.state(t)
        pace = state.speed if is_of_speeds(law) else TOP
        asked = required_at_speeds(law, speed, pace) + MARGIN + speed * (t - NOW)
        worst = max(worst, asked - math.dist(state.at, (x, y)))
    return worst


@given(
    st.booleans(),
    st.tuples(near, near),
    st.lists(st.tuples(st.floats(-14, -1), st.floats(-4, 10), st.floats(0.3, 2)), max_size=3),
    st.sampled_from(LAWS),
)
def test_a_motion_is_safe_for_as_long_as_it_is_said_and_no_longer(gantry, ends, people, law):
    if gantry:
        motion = navigation.gantry_move(*ends, 2.0)
        stops = gantry_stops()
        stop_from = navigation.gantry_stop
    else:
        q = [abs(end[0] + 5) for end in ends]
        motion = navigation.agv_run(LANE, q[0], q[1], 2.0)
        stops = agv_stops(LANE)

        def stop_from(state, t):
            return navigation.agv_stop(LANE, state, t)

    assume(motion.end > NOW)
    rows = []
    for x, y, speed in people:
        known = is_of_speeds(law)
        fixed = -1.0 if known else required_at_speeds(law, speed, TOP) + MARGIN
        rows += (x, y, speed, fixed)
    lookout = StoppingHorizon(law, MARGIN)
    until, who = lookout.safe_until(motion.table, stops, rows, NOW, LEAST)
    looks = [NOW]
    while looks[-1] < motion.end:
        looks.append(min(NOW + LEAST * 2 ** (len(looks) - 1), motion.end))
    assert until in looks
    if until == NOW and who < 0:
        return

    def worst(begin, end, person):
        stop = stop_from(motion.state(end), end)
        return max(lack(motion, begin, end, person, law), lack(stop, end, stop.end, person, law))

    for begin, end in itertools.pairwise(looks):
        if end <= until:
            assert all(worst(begin, end, person) < 1e-6 for person in people)
        elif begin == until:
            # What lacks between two of the instants can't be seen at them.
            assert worst(begin, end, people[who]) > -0.05


@given(
    st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9)), min_size=1, max_size=6),
    st.lists(st.tuples(*[st.floats(-9, 9)] * 2, *[st.floats(-2, 2)] * 2), max_size=3),
)
def test_the_place_on_whose_path_people_stay_farthest_is_found(places, people):
    glances, horizon, top, lag, enough = [0.0, 1.0, 2.0], 1.5, 1.0, 0.5, 4.0

    def nearest(place):
        length = math.dist(places[0], place)
        found = math.inf
        for t, (x, y, vx, vy) in itertools.product(glances, people):
            share = min(1.0, top * max(0.0, t - lag) / length) if length else 0.0
            at = [a + share * (b - a) for a, b in zip(places[0], place, strict=True)]
            after = min(t, horizon)
            found = min(found, math.dist(at, (x + vx * after, y + vy * after)))
        return found

    rows = [c for person in people for c in person]
    flat = [c for place in places for c in place]
    k = most_remote(flat, rows, glances, horizon, top, lag, enough)
    stays = nearest(places[0])
    assert k == 0 or stays < enough + 1e-9
    if stays < enough - 1e-9:
        assert nearest(places[k]) > max(map(nearest, places)) - 1e-9
