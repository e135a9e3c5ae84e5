"""Consequences of a violation under each rule set, from end to end."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from run_events import events
from sample_files import files

import sim

TRAY = np.array([0.2, 0.0])
"""Metres from an AGV's centre to the frame of its tray."""

SAMPLE = 1e-3
"""Seconds between the samples that the monitor is checked against."""


def run(text, **changes):
    return sim.run(replace(sim.Trial.parse(text), **changes))


def parked(rules, people, *, at="[-2.5, 0.5, 0.0]", duration=60, agvs=""):
    """Return a trial around a gantry that stands at `at`."""
    return (
        f"floorplan: ariac2023\nduration: {duration}\nrules: {rules}\npeople: {people}\n"
        f"gantry: {{controller: parked, at: {at}}}\n{agvs}"
    )


def walker(tmp_path, name, program):
    """Write a person's program to a file, and return its path."""
    path = tmp_path / f"{name}.asl"
    path.write_text(program)
    return path


# ---- ariac2023


@pytest.mark.parametrize(
    ("speeds", "metres"),
    [((1.0, 0.0), 1.75 * 3.7), ((1.0, 1.0), 1.75 * 4.7), ((1.5, 1.0), 8.75), ((0.0, 0.0), 2.1)],
)
def test_the_noticing_distance_of_the_competition_is_capped_before_it_is_scaled(speeds, metres):
    assert sim.RULE_SETS["ariac2023"].notice.law.distance(*speeds) == pytest.approx(metres)


def test_the_person_is_also_sent_home_during_the_grace(tmp_path):
    """The person walks towards the gantry again right after each wait."""
    program = walker(
        tmp_path,
        "stubborn",
        "+human_start <- !go. +!go <- move(-4.5, 0, 0). "
        "+gantry_disabled(_) <- teleport_safe; .wait(16000); !!go.",
    )
    people = f"[{{name: a, personality: {program}, at: [-8.0, 0], home: [-8.0, 0]}}]"
    result = run(parked("ariac2023", people))
    violations = events(result, "violation")
    assert [v["penalty"] for v in violations[:2]] == [True, False]
    assert violations[1]["t"] - violations[0]["t"] < 25.0  # 15 s disabled, 10 s of grace
    assert [t["t"] for t in events(result, "teleport")] == [v["t"] for v in violations]
    assert len(events(result, "gantry_disabled")) == result.summary["penalties"]
    assert sum(end - begin for begin, end in result.violations["a", "gantry"]) < SAMPLE
    assert result.summary["agv_teleports"] == 0  # both violations were with the gantry


def test_a_violation_that_lasts_is_a_penalty_again_as_the_grace_ends():
    rules = replace(sim.PAPER, person="none", gantry_disabled=8.0, grace=5.0)
    people = "[{name: a, personality: external, at: [-7.5, 0.5]}]"
    result = run(parked("paper", people, at="[-7.0, 0.0, 0.0]", duration=30), rules=rules)
    penalties = [(v["t"], v["penalty"]) for v in events(result, "violation")]
    assert penalties == [(0.0, True), (13.0, True), (26.0, True)]


@pytest.mark.parametrize(
    "path",
    files("shift.ariac.yaml", real="ariac2023/trials/sample.yaml"),
    ids=lambda path: path.stem,
)
def test_the_person_of_a_competition_file_never_stays_too_close(path):
    result = sim.run(replace(sim.Trial.load(path), until_submitted=False, duration=400.0))
    too_close = sum(end - begin for begin, end in result.violations["operator", "gantry"])
    assert too_close < SAMPLE
    assert result.summary["minimum_separation"]["distance"] > 1.0
    assert (
        len(events(result, "teleport", reason="gantry")) == result.summary["violations"]["person"]
    )


def test_a_violation_that_lasts_is_reported_every_ten_seconds():
    """The home is also too close, because 1 m is required of a person who stands."""
    people = "[{name: a, at: [-3.2, 0.5], home: [-3.2, 0.5]}]"
    result = run(parked("ariac2023", people, duration=25))
    assert [e["t"] for e in events(result, "teleport")] == pytest.approx([0.0, 10.0, 20.0])
    assert [e["seconds"] for e in events(result, "gantry_disabled")] == [15.0] * 3
    assert events(result, "gantry_enabled") == []


@pytest.mark.parametrize("start", [0.0, 7.0])
def test_no_machine_is_noticed_for_twenty_seconds_after_the_start_and_after_a_teleport(start):
    people = f"[{{name: a, start: {{time: {start}}}, at: [-8.5, 0]}}]"
    result = run(parked("ariac2023", people, duration=200))
    early = [event["t"] for event in events(result, "gantry_detected") if event["t"] < start]
    assert early == []
    silent = [start, *(event["t"] for event in events(result, "teleport"))]
    noticed = [event["t"] for event in events(result, "gantry_detected")]
    assert len(silent) > 2
    assert noticed
    for t in noticed:
        assert all(t >= since + 20.0 for since in silent if since <= t)


def test_distances_to_agvs_are_measured_to_their_tray():
    """Compare with samples of the tray, 0.2 m from the centre, where the lane begins."""
    text = parked(
        "{based_on: ariac2023, person: none}",
        "[{name: a, at: [-9.5, 3.5], start: {time: 50}}]",
        agvs="agvs: {agv1: [{time: 1.0, to: warehouse}, {time: 20.0, to: kitting}]}",
    )
    result = run(text)
    t = np.arange(0.0, 40.0, SAMPLE)
    agv, person = result.motions["agv1"], result.motions["a"]
    apart = np.hypot(*(agv.position(t) - person.position(t) + TRAY).T)
    moves = np.hypot(*agv.velocity(t).T) > 0.01
    changes = t[1:][np.diff((apart < 2.1) & moves)]
    ends = [instant for span in result.violations["a", "agv1"] for instant in span]
    assert len(ends) == 4
    assert ends == pytest.approx(changes.tolist(), abs=1.1 * SAMPLE)
    assert result.distance("a", "agv1", t) == pytest.approx(apart)
    for event in events(result, "violation", **{"with": "agv1"}):
        assert event["distance"] == pytest.approx(2.1, abs=1e-6)


# ---- paper

PLACES = (("near", -8.0), ("far", -10.0))


def test_a_violation_of_a_second_person_is_found_while_the_gantry_is_disabled(tmp_path):
    straight = walker(tmp_path, "straight", "+human_start <- move(-4.5, 0.5, 0).")
    people = [f"{{name: {name}, at: [{x}, 0.5], personality: {straight}}}" for name, x in PLACES]
    result = run(parked("paper", f"[{', '.join(people)}]", duration=30))
    first, second = events(result, "violation")
    assert (first["person"], second["person"]) == ("near", "far")
    assert 0 < second["t"] - first["t"] < 8.0
    assert second["distance"] == pytest.approx(second["required"], abs=1e-6)
    assert second["penalty"] is True
    enabled = events(result, "gantry_enabled")[0]["t"]
    assert enabled == pytest.approx(second["t"] + 8.0)


def test_the_antagonistic_person_continues_to_the_next_station_after_the_gantry():
    people = "[{name: a, personality: antagonistic}]"
    result = run(parked("observe", people, at="[-7.0, 0.0, 0.0]", duration=60))
    goals = [event["station"] for event in events(result, "goal")]
    at_gantry = goals.index(None)
    ring = ["station4", "station2", "station1", "station3"]
    interrupted = ring.index(goals[at_gantry - 1])
    assert goals[at_gantry + 1] == ring[(interrupted + 1) % 4]


def test_after_an_agv_the_person_waits_as_long_as_after_the_gantry():
    text = parked(
        "paper",
        "[{name: a, at: [-8.0, 4.0]}]",
        agvs="agvs: {agv1: [{time: 1.0, to: assembly_front}]}",
    )
    result = run(text, duration=30)
    teleport = events(result, "teleport", reason="agv")[0]["t"]
    onwards = next(e["t"] for e in events(result, "goal") if e["t"] > teleport)
    assert onwards == pytest.approx(teleport + 8.0)


# ---- observe, protective_stop, and consequences of a violation


@pytest.mark.parametrize("personality", ["antagonistic", "indifferent"])
def test_observing_only_records_violations(personality):
    people = f"[{{name: a, personality: {personality}}}]"
    result = run(parked("observe", people, duration=120))
    assert events(result, "violation")
    assert events(result, "teleport", "gantry_disabled", "protective_stop", "penalty") == []
    assert result.summary["penalties"] == 0
    assert result.summary["gantry_disabled_time"] == 0.0
    assert result.summary["violations"]["person"] == len(events(result, "violation"))


@pytest.mark.parametrize(
    ("machine", "person", "kinds"),
    [
        ("none", "none", set()),
        ("none", "teleport", {"teleport"}),
        ("stop", "none", {"protective_stop"}),
        ("stop", "teleport", {"protective_stop", "teleport"}),
        ("{disable: 3.0}", "none", {"gantry_disabled"}),
        ("disable", "teleport", {"gantry_disabled", "teleport"}),
    ],
)
def test_a_rule_set_chooses_the_consequences_of_a_violation(machine, person, kinds):
    rules = f"{{name: ours, machine: {machine}, person: {person}}}"
    result = run(parked(rules, "[{name: a, personality: antagonistic}]", duration=40))
    instants = {event["t"] for event in events(result, "violation")}
    followed = {event["kind"] for event in result.events if event["t"] in instants}
    assert instants
    assert followed & {"teleport", "gantry_disabled", "protective_stop"} == kinds
    assert bool(result.summary["penalties"]) == ("gantry_disabled" in kinds)
    if "disable:" in machine:
        assert {e["seconds"] for e in events(result, "gantry_disabled")} == {3.0}


WORK = """
floorplan: ariac2023
duration: 200
rules: protective_stop
people:
  - {name: a, personality: indifferent}
  - {name: b, personality: antagonistic, start: {time: 15}}
gantry:
  controller: oblivious
  repeat: true
  jobs: [{move: [-12, -3, 0]}, {wait: 3}, {move: [-4, 3, 0]}, {wait: 3}]
agvs:
  agv2: [{time: 20, to: warehouse}, {time: 60, to: kitting}, {time: 100, to: warehouse}]
"""


@pytest.fixture(scope="module")
def stopped():
    return run(WORK)


def stops(run, machine):
    """Return when `machine` was stopped, until the end of the run at the latest."""
    spans, since = [], None
    for event in events(run, "protective_stop", "protective_stop_ended", machine=machine):
        if event["kind"] == "protective_stop":
            since = event["t"]
        else:
            spans.append((since, event["t"]))
            since = None
    return spans if since is None else [*spans, (since, run.duration)]


@pytest.mark.parametrize("machine", ["gantry", "agv2"])
def test_a_protective_stop_lasts_from_the_violation_until_there_is_room(stopped, machine):
    """In samples, the machine stands after braking while a person is too close."""
    spans = stops(stopped, machine)
    assert spans
    motion = stopped.motions[machine]
    t = np.arange(0.0, stopped.duration, 0.01)
    moves = np.hypot(*motion.velocity(t).T) > 1e-6
    at_rest = np.zeros(len(t), dtype=bool)
    for begin, end in spans:
        at_rest |= (t >= begin + 3.0) & (t < end)  # braking takes at most 2.5 s
    assert not (moves & at_rest).any()
    for person in ("a", "b"):
        apart = stopped.distance(person, machine, t)
        required = stopped.required(person, machine, t)
        too_close = moves & (apart < required - 1e-6)
        inside = np.zeros(len(t), dtype=bool)
        for begin, end in spans:
            inside |= (t >= begin - 0.01) & (t <= end)
        assert not (too_close & ~inside).any()


@pytest.mark.parametrize(("machine", "top_speed"), [("gantry", math.sqrt(2)), ("agv2", 2.0)])
def test_a_protective_stop_ends_when_there_is_room_for_all_people(stopped, machine, top_speed):
    """People who did not cause the stop also count, because they would cause another at once."""
    ended = events(stopped, "protective_stop_ended", machine=machine)
    assert len(ended) > 1
    for t in (event["t"] for event in ended):
        for person in ("a", "b"):
            walking = np.hypot(*stopped.motions[person].velocity(t))
            room = 2.5 * walking + 1.0 * top_speed + 1.0
            assert stopped.distance(person, machine, t) >= room


def test_a_machine_resumes_after_a_protective_stop_and_does_not_creep(stopped):
    spans = stops(stopped, "gantry")
    assert stopped.summary["jobs_done"] >= 2
    assert all(later - end > 0.1 for (_, end), (later, _) in itertools.pairwise(spans))
    let_go = {event["t"] for event in events(stopped, "protective_stop_ended", machine="agv2")}
    assert let_go <= {event["t"] for event in events(stopped, "agv_moved", agv="agv2")}
    assert events(stopped, "teleport", "gantry_disabled") == []
    total = sum(end - begin for body in ("gantry", "agv2") for begin, end in stops(stopped, body))
    assert stopped.summary["protective_stop_time"] == pytest.approx(total)
    assert stopped.summary["protective_stops"] == len(events(stopped, "protective_stop"))


def test_a_machine_in_a_protective_stop_waits_for_all_people(tmp_path):
    """Both people stand below it, and leave one after the other."""
    leaves = walker(tmp_path, "leaves", "+human_start <- move(-15, -10, 0).")
    people = ", ".join(
        f"{{name: {name}, at: [{x}, 0.0], start: {{time: {start}}}, personality: {leaves}}}"
        for name, x, start in (("a", -6.4, 5), ("b", -7.6, 9))
    )
    text = parked("protective_stop", f"[{people}]", at="[-7.0, 0.0, 0.0]", duration=60)
    work = "controller: oblivious, jobs: [{move: [-2, 6, 0]}]"
    result = run(text.replace("controller: parked", work))
    ((begin, end),) = stops(result, "gantry")
    room = 2.5 + 1.0 * math.sqrt(2) + 1.0 + 0.05
    assert begin == 0.0
    assert result.distance("b", "gantry", end) == pytest.approx(room, abs=1e-6)
    assert result.distance("a", "gantry", end) > room
    assert result.summary["jobs_done"] == 1


def test_a_machine_in_a_protective_stop_is_not_idle():
    """It always moves or is stopped, except for moments between its jobs."""
    result = run(WORK.replace("{wait: 3}, ", "").replace(", {wait: 3}", ""))
    t = np.arange(0.0, result.duration, 0.01)
    busy = np.hypot(*result.motions["gantry"].velocity(t).T) > 0
    for begin, end in stops(result, "gantry"):
        busy |= (t >= begin) & (t < end)
    assert result.summary["gantry_idle_time"] == pytest.approx(0.01 * (~busy).sum(), abs=0.1)
    assert result.summary["gantry_idle_time"] < 1.0
