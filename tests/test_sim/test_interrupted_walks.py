"""Stops and reactions of people who walk along given courses, without a floor."""

import math

import pytest
from crowd_parts import Walkers

from sim.people.crowd.parameters import PARAMETERS


@pytest.fixture
def walkers():
    return Walkers()


def stop_all(walkers, me, **keys):
    now = walkers.clock.now
    return walkers.interruptions.all_stop(me, walkers.interruptions.stop(me, now), **keys)


def test_a_person_can_stop_after_a_while(walkers):
    me = walkers.walker((0, 0), (10, 0))
    walkers.until(3.0)
    stop = walkers.interruptions.stop(me, 5.0)
    assert stop.position(4.9) == pytest.approx(me.body.motion.position(4.9))
    assert stop.end == pytest.approx(6.0, abs=1e-5)


def test_people_who_walk_behind_a_person_who_stops_also_stop(walkers):
    first, second, third = (walkers.walker((x, 0), (x + 10, 0)) for x in (0.0, -0.7, -1.4))
    beside = walkers.walker((0, 0.604), (10, 0.604))
    walkers.until(3.0)
    drafts = stop_all(walkers, first)
    assert [*drafts] == [first, second, third] and beside not in drafts


def test_a_recorded_person_does_not_stop_behind_a_person(walkers):
    first = walkers.walker((0, 0), (10, 0))
    walkers.walker((-0.7, 0), (9.3, 0), recorded=True)
    walkers.until(3.0)
    assert stop_all(walkers, first) is None


def test_a_person_does_not_stop_in_front_of_a_follower_who_is_too_fast_to_stop(walkers):
    first = walkers.walker((0, 0), (20, 0), speed=0.5)
    walkers.walker((-3.4, 0), (20, 0), speed=1.5)
    walkers.until(3.0)
    assert stop_all(walkers, first) is None


def test_people_who_stop_for_each_other_ignore_vehicles_only_if_asked_to(walkers):
    me = walkers.walker((0, 0), (10, 0))
    walkers.vehicle((8, 0), (0, 0))
    walkers.until(3.5)
    assert stop_all(walkers, me) is None
    assert [*stop_all(walkers, me, among_vehicles=True)] == [me]


def test_a_person_halts_as_soon_as_a_recorded_follower_allows(walkers):
    me = walkers.walker((0, 0), (10, 0))
    walkers.walker((-0.8, 0), (4, 0), (4, 9), recorded=True)
    walkers.until(3.0)
    walkers.interruptions.halt(me, lambda stop: True)
    (stop,) = walkers.committed.values()
    late = (stop.end - 4.0) / PARAMETERS.clear_time
    assert late > 2.0 and late == pytest.approx(round(late), abs=1e-3)
    assert walkers.table.others(me, me.swath.box, 3.0).free(me.swath)


def test_a_person_does_not_search_for_halts_beyond_the_closed_place(walkers):
    me = walkers.walker((0, 0), (10, 0))
    walkers.walker((-0.8, 0), (4, 0), (4, 9), recorded=True)
    walkers.until(3.0)
    walkers.interruptions.halt(me, lambda stop: stop.end < 4.15)
    assert walkers.committed == {}
    assert 4.15 < me.body.motion.end < 8.0


def test_a_person_brakes_later_if_a_follower_is_near(walkers):
    me = walkers.walker((0, 0), (10, 0))
    walkers.walker((-0.8, 0), (4, 0), (4, 9), recorded=True)
    walkers.until(3.0)
    braking = walkers.interruptions.braking(me)
    assert braking.end > 4.1
    assert walkers.interruptions.braking(me, alone=True).end == pytest.approx(4.0, abs=1e-5)


def test_a_recorded_person_makes_only_people_with_a_goal_replan(walkers):
    measured = walkers.walker((0, 0), (10, 0), recorded=True)
    walkers.walker((5, 0), goal=False)
    goes = walkers.walker((7, 0.5), (7.0, 0.4))
    walkers.walker((9, 3))
    with pytest.raises(AssertionError, match="looks for a place"):
        walkers.interruptions.make_way_for(measured)
    assert walkers.decided == [goes]


def test_people_search_no_place_if_the_path_is_free(walkers):
    measured = walkers.walker((0, 0), (10, 0), recorded=True)
    walkers.walker((5, 2), goal=False)
    walkers.interruptions.make_way_for(measured)
    assert walkers.decided == [] and walkers.committed == {}


# Vehicles


def met_at(me, vehicle, until=40.0):
    """When a person and a vehicle of the same size meet (s)."""
    t = 0.0
    while math.dist(me.body.motion.position(t), vehicle.body.motion.position(t)) > 0.606:
        t += 1e-3
        assert t < until
    return t


def test_people_have_an_alarm_before_a_vehicle_comes(walkers):
    rests, walks = walkers.walker((0, 0), goal=False), walkers.walker((0, 4), (5, 4))
    far, measured = walkers.walker((0, -9)), walkers.walker((8, 0), recorded=True)
    vehicles = [walkers.vehicle((20, y), (-2, y)) for y in (0, 4)]
    walkers.steps_aside.notice(vehicles)
    walkers.until(0.1)
    for me, vehicle in zip((rests, walks), vehicles, strict=True):
        due = met_at(me, vehicle) - PARAMETERS.alarm
        assert me.stepping.time == pytest.approx(due, abs=0.01)
    walkers.steps_aside.watch(measured)
    assert far.stepping.time is None and measured.stepping.time is None


def test_no_alarm_is_set_for_a_meeting_with_a_person(walkers):
    me = walkers.walker((0, 0), (9, 0))
    walkers.walker((20, 0), (0, 0))
    walkers.steps_aside.notice([walkers.vehicle((20, 9), (0, 9))])
    walkers.until(0.1)
    assert me.stepping.time is None


def test_a_person_who_looked_for_a_place_just_now_looks_again_later(walkers):
    me = walkers.walker((0, 0), goal=False)
    vehicle = walkers.vehicle((4, 0), (-4, 0))
    walkers.steps_aside.notice([vehicle])
    me.stepped = 0.0
    walkers.until(0.1)
    assert me.stepping.time == pytest.approx(PARAMETERS.early)


@pytest.mark.parametrize(("arrival", "before"), [(1.0, None), (8.0, PARAMETERS.hurry)])
def test_a_person_who_is_about_to_arrive_arrives_before_the_alarm(walkers, arrival, before):
    me = walkers.walker((0, 0), goal=False)
    vehicle = walkers.vehicle((6, 0), (-4, 0))
    me.arriving.set(arrival)
    walkers.steps_aside.notice([vehicle])
    walkers.until(0.1)
    met = met_at(me, vehicle)
    due = arrival + PARAMETERS.early if before is None else met - before
    assert met < 7.0 and me.stepping.time == pytest.approx(due, abs=0.01)


def postpone_alarms(walkers):
    """Prevent searches for a place within the next `PARAMETERS.early` seconds."""
    for me in walkers.people:
        me.stepped = walkers.clock.now


def test_people_who_walk_towards_a_vehicle_replan(walkers):
    walks = walkers.walker((0, 0), (10, 0))
    walkers.walker((3, 0), goal=False)
    aside, measured = (
        walkers.walker((0, 4), (10, 4)),
        walkers.walker((0, 0.7), (10, 0.3), recorded=True),
    )
    walkers.walker((10, 4), (0, 4), goal=False)  # this person is no vehicle
    postpone_alarms(walkers)
    walkers.steps_aside.notice([walkers.vehicle((6, 0), (0, 0))])
    walkers.until(0.1)
    assert walkers.decided == [walks]
    assert aside.goal and measured.goal


def test_people_do_not_react_to_a_vehicle_that_others_noticed_before(walkers):
    walks = walkers.walker((0, 0), (10, 0))
    walkers.walker((0, 9), (9, 9))
    postpone_alarms(walkers)
    walkers.steps_aside.notice([walkers.vehicle((6, 0), (0, 0))])
    walkers.until(0.1)
    walkers.steps_aside.notice([walkers.vehicle((6, 20), (0, 20))])
    walkers.until(0.2)
    assert walkers.decided == [walks]


def test_a_walking_person_stops_for_a_vehicle_that_crosses_and_has_no_alarm_then(walkers):
    me = walkers.walker((0, 0), (9, 0))
    walkers.walker((0, 9))
    crossing = walkers.vehicle((5.5, -5.5), (5.5, 9))
    walkers.steps_aside.notice([crossing])
    walkers.until(1.0)
    (motion,) = walkers.committed.values()
    assert motion is me.body.motion
    assert motion.position(motion.end)[0] < 4.9
    assert walkers.table.only(me, crossing, 1.0).free(me.swath)
    assert me.stepping.time is None


def test_a_person_stops_only_where_no_person_follows(walkers):
    me = walkers.walker((0, 0), (9, 0))
    behind = walkers.walker((-0.7, 0), (2, 0), (2, 5))
    crossing = walkers.vehicle((5.5, -5.5), (5.5, 9))
    walkers.steps_aside.notice([crossing])
    walkers.until(1.5)
    assert me in walkers.committed
    for other in (behind, crossing):
        assert walkers.table.only(me, other, 1.5).free(me.swath)
