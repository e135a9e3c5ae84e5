"""Stationary times of machines: their causes, people, and the omitted warm-up of a report."""

import numpy as np
import pytest
from run_events import events
from small_floors import GANTRY, LANE, on_floor

import sim
from sim.record.incidents import incidents, time_on_floor, time_too_close
from sim.record.stops import machine_times, times_of_all
from sim.record.warm_up import after_warm_up, contacts_of, zones_of

FLOOR = (
    """\
boundary: [[0, 0], [20, 0], [20, 12], [0, 12]]
stations: {west: [2, 5], east: [18, 6]}
safe_zone: {at: [2, 5]}
zones: {middle: {x: [8, 12], y: [2, 9], max_speed: 2.0}}
"""
    + GANTRY
    + LANE
)
STANDING = "[{name: eve, personality: external, at: [10, 5]}]"
WALKING = "[{name: eve}, {name: ada, at: [17, 6], max_speed: 0.7}]"
MOVES = "[{move: [15, 6, 0]}, {wait: 4}, {move: [5, 6, 0]}]"


def run(rules="observe", people=STANDING, jobs=MOVES, controller="oblivious", **keys):
    more = "".join(f"{key}: {value}\n" for key, value in keys.items())
    text = (
        f"rules: {{based_on: {rules}, gantry_law: {{fixed: 3.0}}, agv_law: {{fixed: 2.0}}}}\n"
        f"duration: 30\npeople: {people}\n"
        f"gantry: {{at: [5, 6, 0], controller: {controller}, jobs: {jobs}}}\n{more}"
    )
    return sim.run(sim.Trial.parse(on_floor(FLOOR, text)))


def times_of(finished, machine="gantry", since=0.0):
    """Return the times of a machine, whose sum is the time of the run after its warm-up."""
    (one,) = (
        one for one in machine_times(after_warm_up(finished, since)) if one.machine == machine
    )
    whole = one.moving + sum(one.stopped.values())
    assert whole == pytest.approx(finished.duration - since, abs=1e-6)
    assert sum(seconds for _, seconds in one.whom.values()) <= whole + 1e-6
    return one


def test_a_waiting_gantry_names_the_person():
    finished = run(controller="pausing")
    yielded = events(finished, "gantry_yielded")
    assert {event["person"] for event in yielded} == {"eve"}
    assert all(event["distance"] > event["required"] for event in yielded)
    times = times_of(finished)
    motion, t = finished.motions["gantry"], np.linspace(0, 30, 3001)
    stood = np.mean(np.hypot(*motion.velocity(t).T) == 0.0) * 30
    assert times.stopped == {"people": pytest.approx(stood, abs=0.05)}
    # The gantry may brake and resume before it stands.
    ((key, (count, seconds)),) = times.whom.items()
    assert key == ("people", "eve") and 1 <= count <= len(yielded)
    assert seconds == times.stopped["people"]
    assert times.had_jobs and times.jobs_done == 0


@pytest.mark.parametrize("controller", ["pausing", "avoiding"])
@pytest.mark.parametrize("seed", range(3))
def test_a_gantry_without_other_reasons_only_waits_for_people(controller, seed):
    jobs = "[{move: [15, 6, 0]}, {move: [5, 6, 0]}]"
    finished = run(people=WALKING, jobs=jobs, controller=controller, seed=seed)
    times = times_of(finished)
    assert {*times.stopped} <= {"people", "nothing to do"}
    assert times.stopped.get("people", 0.0) <= finished.summary["gantry_idle_time"] + 1e-6
    done = [event["t"] for event in events(finished, "job_done")]
    assert times.jobs_done == len(done)
    if len(done) == 2:
        assert times.stopped["nothing to do"] == pytest.approx(30 - done[1], abs=1e-6)
    else:
        assert "nothing to do" not in times.stopped


def test_waiting_in_a_job_differs_from_having_no_job():
    times = times_of(run(people="[]"))
    assert times.stopped["job wait"] == pytest.approx(4.0)
    assert {*times.stopped} == {"job wait", "nothing to do"} and times.jobs_done == 3
    assert times_of(run(people="[]", jobs="[]")).stopped == {"nothing to do": 30.0}


@pytest.mark.parametrize(
    ("rules", "cause", "figure"),
    [
        ("paper", "penalty", "gantry_disabled_time"),
        ("protective_stop", "protective stop", "protective_stop_time"),
    ],
)
def test_stops_by_the_rules_have_their_cause(rules, cause, figure):
    finished = run(rules)
    times = times_of(finished)
    braking = 30 - times.moving - sum(times.stopped.values())
    assert braking == pytest.approx(0.0, abs=1e-6)
    # While the gantry brakes it moves, and is disabled or stopped already.
    assert 0 < times.stopped[cause] <= finished.summary[figure]
    assert times.stopped[cause] > finished.summary[figure] - 3.0 * len(
        events(finished, "violation")
    )
    assert {key for key in times.whom if key[0] == cause} == {(cause, "eve")}


def test_agvs_yield_are_held_and_arrive():
    moves = "{cart: {yield: true, moves: [{time: 0, to: east}]}}"
    hold = "[{time: 2, hold: cart}, {time: 12, release: cart}]"
    finished = run(people="[{name: eve, personality: external, at: [11, 4]}]", agvs=moves)
    times = times_of(finished, "cart")
    (yielded,) = events(finished, "agv_yielded")
    assert times.whom == {("people", "eve"): (1, times.stopped["people"])}
    assert times.stopped["people"] < 30 - yielded["t"] and not times.had_jobs
    stopped = times_of(run(people="[]", agvs=moves, commands=hold), "cart")
    # the vehicle brakes from 1 m/s
    assert stopped.stopped["hold"] == pytest.approx(10 - 2.0, abs=0.01)
    assert {*stopped.stopped} == {"hold"} or stopped.stopped["nothing to do"] > 0


def test_times_of_several_runs_are_added():
    one, other = (machine_times(run(controller=name)) for name in ("pausing", "oblivious"))
    both = times_of_all([one, other])
    assert [times.machine for times in both] == [times.machine for times in one]
    assert both[0].moving == one[0].moving + other[0].moving
    assert both[0].jobs_done == one[0].jobs_done + other[0].jobs_done
    assert sum(both[0].stopped.values()) + both[0].moving == pytest.approx(60.0)


def test_stops_in_the_warm_up_are_omitted():
    finished = run(people="[{name: eve, at: [5, 5]}, {name: ada, at: [17, 6]}]")
    spans = sorted(span for some in finished.violations.values() for span in some)
    assert spans[0][0] == 0.0 and len(spans) > 1
    since = (spans[0][1] + spans[1][0]) / 2 if spans[0][1] < spans[1][0] else spans[0][1]
    later = after_warm_up(finished, since)
    begins = [one.begin for one in incidents(finished) if one.end > since]
    assert [one.begin for one in incidents(later)] == [max(begin, since) for begin in begins]
    assert len(begins) < len(spans)
    assert time_on_floor(later) == pytest.approx(2 * (30 - since))
    assert time_too_close(later) < time_too_close(finished)
    assert after_warm_up(finished, 0.0) is finished


def test_a_violation_that_lasts_beyond_the_warm_up_counts_from_its_end():
    finished = run()
    (begin, end), *_ = finished.violations["eve", "gantry"]
    since = (begin + end) / 2
    first = incidents(after_warm_up(finished, since))[0]
    assert (first.begin, first.end) == (since, end)
    assert first.distance == pytest.approx(float(finished.distance("eve", "gantry", since)))
    assert (first.required, first.cause) == (3.0, "")
    assert first.margin == pytest.approx(
        min(one.margin for one in incidents(finished)[:1]), abs=2.0
    )


def test_contacts_and_zones_of_a_whole_run_equal_its_summary():
    finished = run(people="[{name: eve, at: [5, 5]}, {name: ada, at: [10, 2.9]}]", seed=2)
    assert contacts_of(finished) == finished.summary["contacts"]
    mine, theirs = zones_of(finished), finished.summary["zones"]
    assert mine.keys() == theirs.keys()
    for zone, figures in mine.items():
        assert figures == pytest.approx(theirs[zone], abs=1e-6)
    assert (
        zones_of(after_warm_up(finished, 15.0))["middle"]["time_occupied"]
        <= (mine["middle"]["time_occupied"])
    )


def test_a_vehicle_that_waits_for_another_names_it():
    text = """
floorplan: {boundary: [[0, 0], [20, 0], [20, 12], [0, 12]]}
duration: 60
rules: observe
machines:
  a: &tug
    kind: agv
    origin: [10, 1.5]
    heading: 1.5707963
    limits: [0, 9]
    moves: [{time: 1, to: 9}]
  b: {<<: *tug, origin: [5.5, 6], heading: 0}
"""
    finished = sim.run(sim.Trial.parse(text))
    assert finished.summary["waiting_time"] > 0
    seconds = {name: times_of(finished, name).stopped.get("traffic", 0.0) for name in "ab"}
    # A vehicle that has to wait brakes at first, which counts as moving.
    assert 0 < sum(seconds.values()) <= finished.summary["waiting_time"]
    waits = {(e["machine"], e["for_machine"]) for e in events(finished, "machine_waiting")}
    whom = {
        (n, who) for n in "ab" for cause, who in times_of(finished, n).whom if cause == "traffic"
    }
    assert whom and whom <= waits
