"""Reactions to occupied fields: response, restart, short intrusions, muting and missing sets."""

import textwrap
from types import SimpleNamespace

import numpy as np
import pytest
from run_events import events
from small_floors import on_floor

import navigation
import sim
from navigation import Apart, FixedDistance, TooClose
from sim.core.clock import Clock
from sim.safety.fields.reaction import Reaction
from sim.safety.proximity import NearnessMonitor, by_conditions

RESPONSE, DELAY = 0.2, 2.0


class Watched:
    """A reaction, with a log of its begins and ends."""

    def __init__(self, delay=DELAY, response=RESPONSE):
        self.clock = Clock()
        self.log = []
        fields = SimpleNamespace(response_time=response, restart_delay=delay)
        self.reaction = Reaction(
            self.clock,
            fields,
            lambda cause, person: self.log.append((round(self.clock.now, 9), cause, person)),
            lambda: self.log.append(round(self.clock.now, 9)),
        )

    def at(self, t, cause, person=""):
        self.clock.run(until=t)
        self.reaction.become(cause, person)

    def until(self, t):
        self.clock.run(until=t)
        return self.log


def test_a_reaction_begins_after_the_response_time_and_ends_after_the_delay():
    one = Watched()
    one.at(1.0, "intrusion", "ann")
    one.at(5.0, "")
    assert one.until(20.0) == [(1.2, "intrusion", "ann"), 7.0]


def test_a_trigger_shorter_than_the_response_time_counts():
    one = Watched()
    one.at(1.0, "intrusion", "ann")
    one.at(1.05, "")
    assert one.until(20.0) == [(1.2, "intrusion", "ann"), 3.05]
    soon = Watched(delay=0.01)
    soon.at(1.0, "intrusion", "ann")
    soon.at(1.05, "")
    assert soon.until(20.0) == [(1.2, "intrusion", "ann"), 1.2]


def test_the_first_cause_counts():
    one = Watched()
    one.at(1.0, "intrusion", "ann")
    one.at(1.1, "blackout")
    one.at(5.0, "")
    assert one.until(20.0) == [(1.2, "intrusion", "ann"), 7.0]


def test_the_delay_begins_again_with_each_intrusion():
    one = Watched()
    one.at(1.0, "intrusion", "ann")
    for begin in (3.0, 4.5, 6.0):
        one.at(begin - 1.0, "")
        one.at(begin, "intrusion", "bob")
    one.at(7.0, "")
    assert one.until(20.0) == [(1.2, "intrusion", "ann"), 9.0]
    one.at(21.0, "intrusion", "cy")
    assert one.until(25.0)[2:] == [(21.2, "intrusion", "cy")]


def test_a_reaction_lasts_through_an_intrusion_during_the_delay():
    one = Watched()
    one.at(1.0, "intrusion", "ann")
    one.at(2.0, "")
    one.at(3.0, "intrusion", "bob")
    one.at(8.0, "")
    assert one.until(20.0) == [(1.2, "intrusion", "ann"), 10.0]


def test_the_delay_begins_only_when_an_intrusion_ends():
    one = Watched()
    one.at(1.0, "intrusion", "ann")
    one.at(3.0, "")
    one.at(4.0, "")
    assert one.until(20.0) == [(1.2, "intrusion", "ann"), 5.0]


def test_each_approach_of_one_motion_is_notified():
    clock, notified = Clock(), []
    drive = navigation.Motion.from_samples(
        [0.0, 2.0, 4.0, 6.0, 8.0], [(5.0, 0.0), (0.5, 0.0), (5.0, 0.0), (0.5, 0.0), (5.0, 0.0)]
    )
    bodies = [
        SimpleNamespace(motion=one, on_change=[]) for one in (navigation.standing((0, 0)), drive)
    ]
    near, parted = TooClose(FixedDistance(1.0)), Apart(1.1)
    stage = SimpleNamespace(clock=clock, end=20.0)
    NearnessMonitor(stage, bodies, by_conditions(near, parted), notified.append)
    clock.run(until=20.0)
    assert notified == [True, False, True, False]


def test_a_machine_rests_before_the_reaction_ends():
    one = Watched(delay=0.01)
    one.at(1.0, "intrusion", "ann")
    one.clock.run(until=1.3)
    one.reaction.rests_from(4.0)
    one.at(1.5, "")
    assert one.until(20.0) == [(1.2, "intrusion", "ann"), 4.0]
    late = Watched()
    late.at(1.0, "intrusion", "ann")
    late.at(1.5, "")
    late.clock.run(until=3.0)
    late.reaction.rests_from(8.0)
    assert late.until(20.0) == [(1.2, "intrusion", "ann"), 8.0]


def test_a_reaction_can_be_tripped_at_once():
    one = Watched()
    one.at(1.0, "intrusion", "ann")
    one.reaction.trip()
    assert one.until(1.1) == [(1.0, "intrusion", "ann")]
    quiet = Watched()
    quiet.reaction.trip()
    assert quiet.until(9.0) == []
    none = Watched(response=0.0)
    none.at(1.0, "intrusion", "ann")
    assert none.until(1.0001) == [(1.0, "intrusion", "ann")]


FLOOR = """\
boundary: [[0, 0], [30, 0], [30, 12], [0, 12]]
stations: {east: [27, 3]}
human: {radius: 0.3}
"""


def run(fields, people="[]", floor="", more="", duration=40):
    """Return the run of a vehicle that drives east on y = 3, with fields."""
    text = f"""
    duration: {duration}
    rules: observe
    people: {people}
    machines:
      fork:
        kind: amr
        at: [3, 3, 0]
        size: [1.2, 0.8]
        max_speed: 1.0
        missions: [{{go: east}}]
    fields: {{fork: {{response_time: 0.2, {fields}}}}}
    """
    text = on_floor(FLOOR + floor, textwrap.dedent(text)) + more
    return sim.run(sim.Trial.parse(text))


FRONT = "protective: [[2.5, 0.8], [-0.8, 0.8], [-0.8, -0.8], [2.5, -0.8]]"


def test_a_short_intrusion_stops_the_machine_even_without_a_restart_delay(tmp_path):
    (tmp_path / "walk.csv").write_text("".join(walked()))
    people = "[{name: eve, recorded: walk.csv}]"
    text = f"""
    duration: 40
    rules: observe
    people: {people}
    machines:
      fork: {{kind: amr, at: [3, 3, 0], size: [1.2, 0.8], max_speed: 1.0, missions: [{{go: east}}]}}
    fields: {{fork: {{response_time: 0.2, restart_delay: 0.01, sets: [{{name: a, {FRONT}}}]}}}}
    """
    result = sim.run(sim.Trial.parse(on_floor(FLOOR, textwrap.dedent(text)), folder=tmp_path))
    (stop,), (ended,) = events(result, "field_stop"), events(result, "field_stop_ended")
    (occupied,), (free,) = events(result, "field_occupied"), events(result, "field_free")
    assert free["t"] < stop["t"] + 1.0  # long before the machine is at rest
    motion = result.motions["fork"]
    braking = navigation.vehicle_stop(
        motion.state(stop["t"]), stop["t"], limits=navigation.VehicleLimits(speed=1.0)
    )
    assert stop["t"] == pytest.approx(occupied["t"] + 0.2, abs=1e-9)
    assert ended["t"] == pytest.approx(braking.end, abs=1e-6)
    assert motion.state(ended["t"]).speed == pytest.approx(0.0, abs=1e-6)
    assert motion.state(ended["t"] + 1.0).speed > 0.1
    figures = result.summary["machines"]["fork"]
    assert figures["field_stop_time"] == pytest.approx(ended["t"] - stop["t"])
    assert len(events(result, "job_done")) == 1


def walked():
    """Return a person who runs through the field of the machine in about half a second."""
    yield "name,t,x,y\n"
    for k in range(0, 401):
        t = k / 10
        y = 9.0 if t < 8.0 else max(0.6, 9.0 - 3.9 * (t - 8.0))
        yield f"eve,{t},13.0,{y}\n"


def test_no_set_is_required_while_the_fields_are_muted():
    sets = f"sets: [{{name: slow, linear: [-0.1, 0.4], {FRONT}}}]"
    dock = "zones: {dock: {x: [0, 15], y: [0, 6], max_speed: 3.0}}\n"
    result = run(f"{sets}, muting: [dock]", floor=dock)
    (unmuted,) = events(result, "fields_unmuted")
    motion = result.motions["fork"]
    assert motion.position(unmuted["t"])[0] == pytest.approx(15.0, abs=1e-6)
    assert motion.velocity(unmuted["t"])[0] == pytest.approx(1.0)
    first = events(result, "field_stop")[0]
    assert first["t"] == pytest.approx(unmuted["t"] + 0.2) and first["cause"] == "no field set"
    bare = run(sets)
    first = events(bare, "field_stop")[0]
    fast = next(t for t in np.arange(0, 9, 1e-3) if bare.motions["fork"].velocity(t)[0] > 0.4)
    assert first["t"] == pytest.approx(fast + 0.2, abs=2e-3)
    assert "person" not in first


def test_the_first_velocity_without_a_set_stops_the_machine():
    # The speed is between both sets twice, during acceleration and during braking.
    result = run(
        f"sets: [{{name: slow, linear: [-0.1, 0.4], {FRONT}}},"
        f" {{name: fast, linear: [0.6, 1.1], {FRONT}}}]"
    )
    stop = events(result, "field_stop")[0]
    speed = result.motions["fork"].velocity
    enters = next(t for t in np.arange(0, 9, 1e-3) if speed(t)[0] > 0.4)
    assert stop["cause"] == "no field set"
    assert stop["t"] == pytest.approx(enters + 0.2, abs=2e-3)


def test_people_in_both_fields_at_the_start_trip_them_at_once():
    warning = "warning: [[4.5, 2], [-0.8, 2], [-0.8, -0.8], [4.5, -0.8]]"
    result = run(
        f"sets: [{{name: a, {FRONT}, {warning}}}]",
        "[{name: eve, personality: external, at: [5, 3]}]",
    )
    (stop,), (slowdown,) = events(result, "field_stop"), events(result, "field_slowdown")
    assert stop["t"] == slowdown["t"] == 0.0
    assert stop["person"] == slowdown["person"] == "eve"
    assert result.motions["fork"].position(40.0) == pytest.approx((3.0, 3.0))


def test_a_blackout_in_the_warning_field_stops_without_a_person_and_slows_for_one():
    warning = "warning: [[30, 5], [-0.8, 5], [-0.8, -5], [30, -5]]"
    more = "blackouts: [{machine: fork, start: {time: 5}, seconds: 4}]\n"
    result = run(
        f"restart_delay: 1, sets: [{{name: a, {FRONT}, {warning}}}]",
        "[{name: eve, personality: external, at: [15, 7]}]",
        more=more,
    )
    (stop,), (ended,) = events(result, "field_stop"), events(result, "field_stop_ended")
    assert (stop["t"], stop["cause"]) == (5.2, "blackout") and "person" not in stop
    assert ended["t"] == pytest.approx(10.0)
    assert {one["person"] for one in events(result, "field_slowdown")} == {"eve"}


def test_times_of_stops_and_slowdowns_agree_with_events():
    warning = "warning: [[4.5, 0.8], [-0.8, 0.8], [-0.8, -0.8], [4.5, -0.8]]"
    people = "[{name: eve, personality: external, at: [15, 3], max_speed: 0.1}]"
    more = "commands: [{time: 25, send: eve, to: [15, 9]}]\n"
    keys = f"restart_delay: 1, warning_speed: 0.3, sets: [{{name: a, {FRONT}, {warning}}}]"
    result = run(keys, people, more=more, duration=60)
    stops, slows = (
        list(zip(events(result, f"{kind}"), events(result, f"{kind}_ended"), strict=True))
        for kind in ("field_stop", "field_slowdown")
    )
    figures = result.summary["machines"]["fork"]
    stopped = sum(end["t"] - begin["t"] for begin, end in stops)
    slow = sum(end["t"] - begin["t"] for begin, end in slows)
    assert figures["field_stops"] == len(stops) == 1
    assert figures["field_stop_time"] == pytest.approx(stopped)
    assert figures["field_slow_time"] == pytest.approx(slow - stopped)
    (begin, end) = slows[0]
    motion = result.motions["fork"]
    slowed = np.arange(begin["t"] + 2.0, end["t"], 0.01)
    assert np.hypot(*motion.velocity(slowed).T).max() <= 0.3 + 1e-6
    assert motion.velocity(begin["t"])[0] == pytest.approx(1.0)
    assert np.hypot(*motion.velocity(np.arange(end["t"], 60, 0.01)).T).max() > 0.9
