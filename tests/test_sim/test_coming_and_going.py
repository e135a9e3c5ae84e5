"""Sources and sinks: people who enter later, and leave the floor."""

from __future__ import annotations

import dataclasses
import itertools
import math
import sqlite3

import numpy as np
import pandas as pd
import pytest
from run_events import events

import navigation
import sim

TRIAL = """
floorplan:
  name: hall
  boundary: [[0, 0], [12, 0], [12, 6], [0, 6]]
  stations: {desk: [6, 3], gate: [1, 1], out: [11, 5]}
  safe_zone: {at: [2, 5]}
duration: 40.0
people:
  - {name: host, personality: external}
  - name: guest
    personality: visitor
    source: {at: gate, rate: 0.5, count: 5}
    sink: out
    beliefs: ["calls(1)"]
expect: {entered: 5, left: 5, overlaps: 0}
"""


@pytest.fixture(scope="module")
def guests(run: sim.Run) -> list[str]:
    return [name for name in run.summary["people"] if name.startswith("guest")]


def test_people_enter_do_their_work_and_leave(run, guests):
    assert run.unmet == [] and len(guests) == 5
    for name in guests:
        figures = run.summary["people"][name]
        called, last = figures["visits"]
        assert called in ("desk", "gate") and last == "out"
        entered, left = (
            next(e for e in events(run, k) if e["person"] == name) for k in ("entered", "left")
        )
        assert figures["started"] == pytest.approx(entered["t"]) and figures["left"] == left["t"]
        assert np.hypot(*np.subtract(entered["at"], (1, 1))) <= 1.0
        assert np.hypot(*np.subtract(left["at"], (11, 5))) <= 1.0


def test_absent_people_are_far_from_the_floor(run, guests):
    """Before and after their stay, people are far from the floor and from each other."""
    for name in guests:
        begin, end = run.presence[name]
        inside = run.motions[name].position(np.linspace(begin, end - 1e-6, 200))
        assert ((inside >= 0) & (inside <= (12, 6))).all()
        outside = run.motions[name].position(np.array([0.0, begin - 1e-6, end, run.duration]))
        assert (outside < -900).all()
    for a, b in itertools.combinations(guests, 2):
        assert navigation.minimum_separation(run.motions[a], run.motions[b], 0, 40)[1] >= 0.6


def test_metrics_count_the_time_on_the_floor(run, guests):
    for name in guests:
        begin, end = run.presence[name]
        figures = run.metrics["people"][name]
        assert figures["time"] == pytest.approx(end - begin)
        assert figures["path_length"] == pytest.approx(
            run.summary["people"][name]["distance_walked"]
        )
        assert figures["final_distance_to_goal"] < 1.0
        assert all(
            apart["maximum"] is None or apart["maximum"] < 14
            for apart in figures["distance_to"].values()
        )


def test_a_recording_and_its_exports_contain_people_only_while_present(run, guests, tmp_path):
    recording = sim.Recording(tmp_path / "run")
    again = sim.run(run.trial, recording)
    recording.finish(again)
    read = sim.load_run(tmp_path / "run")
    assert read.presence == again.presence == run.presence
    table = pd.read_csv(tmp_path / "run" / "trajectory.csv")
    for name in guests:
        begin, end = run.presence[name]
        t = table[table.body == name].t
        assert begin <= t.min() < begin + 0.1 and end - 0.1 <= t.max() < end
    assert table.x.between(0, 12).all() and (table[table.body == "host"].t.max() == 40)
    sim.export(read, tmp_path / "run.parquet", rate=10.0)
    columns = pd.read_parquet(tmp_path / "run.parquet")
    table = pd.DataFrame(read.table(10.0))
    pd.testing.assert_frame_equal(columns.astype({"body": table["body"].dtype}), table)
    assert len(columns) == len(table) and columns.x.to_numpy() == pytest.approx(table.x, abs=1e-6)
    sim.export(read, tmp_path / "run.sqlite", rate=10.0)
    with sqlite3.connect(tmp_path / "run.sqlite") as database:
        rows = database.execute(
            "SELECT id, count(*), min(pos_x), max(pos_x) FROM trajectory_data GROUP BY id"
        ).fetchall()
    assert len(rows) == 6 and all(low >= 0 and high <= 12 for _, _, low, high in rows)
    assert sum(count for _, count, _, _ in rows) == len(table)


def test_a_person_without_room_at_the_entrance_waits_outside():
    """A person stands on the entrance for the whole trial, so no one enters."""
    text = TRIAL.replace(
        "{name: host, personality: external}",
        "{name: host, personality: external, at: [1, 1], radius: 0.9}",
    )
    run = sim.run(dataclasses.replace(sim.Trial.parse(text), duration=15.0))
    assert run.summary["entered"] == 0 and run.summary["people"]["guest1"]["started"] is None
    assert run.metrics["people"]["guest1"]["time"] == 0.0


def test_a_trial_is_written_and_read_back():
    trial = sim.Trial.parse(TRIAL)
    assert [person.name for person in trial.people] == ["host", *(f"guest{k}" for k in range(1, 6))]
    assert sim.Trial.parse(trial.to_yaml()) == trial


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            ("at: gate", "at: gaet"),
            r"line 12, people\[1\].source.at: no station or door is called 'gaet'",
        ),
        (("at: gate", "at: [0.1, 1]"), r"line 12, people\[1\].source.at: .*0\.1"),
        (("sink: out", "sink: [30, 2]"), r"line 13, people\[1\].sink: .*30"),
        (("rate: 0.5", "rate: 0"), r"line 12, people\[1\].source.rate: expected more than 0"),
        (("rate: 0.5, count: 5", "rate: 0.5"), r"line 12, people\[1\].source: .*give count"),
        (("    sink: out", "    at: [2, 2]"), r"people\[1\]: .*at cannot be combined with source"),
        (("host,", "host, group: crew,"), r"line 9, people\[0\].group: a group has from 2 to 5"),
        (("sink: out", "manners: {comfort: -1}"), "line 13, people.*comfort"),
    ],
)
def test_invalid_entrances_and_exits_are_errors_before_the_run(change, message):
    with pytest.raises(sim.TrialError, match=message):
        sim.Trial.parse(TRIAL.replace(*change))


DOORS = """
floorplan:
  name: hall
  boundary: [[0, 0], [12, 0], [12, 6], [0, 6]]
  doors:
    gate: {between: [[0, 2], [0, 3.5]]}
    out: {between: [[12, 2], [12, 3.5]], open: false}
duration: 60.0
doors: {out: {open: [[40.0]]}}
people:
  - {name: guest, personality: visitor, source: {at: gate, rate: 0.5, count: 3}, sink: out}
"""


def test_people_enter_and_leave_through_open_doors():
    """A person at a closed door waits there until it opens."""
    run = sim.run(sim.Trial.parse(DOORS))
    assert run.summary["entered"] == run.summary["left"] == 3
    assert all(0.3 < e["at"][0] < 1.4 for e in events(run, "entered"))
    left = events(run, "left")
    assert all(e["at"][0] > 10.5 and 40.0 <= e["t"] < 45.0 for e in left)
    assert [e["t"] for e in events(run, "door_opened") if e["door"] == "out"] == [40.0]


def test_a_single_person_enters_and_leaves():
    text = DOORS.replace("count: 3", "count: 1")
    run = sim.run(sim.Trial.parse(text))
    assert run.summary["entered"] == run.summary["left"] == 1
    assert "overlaps" not in run.summary


OUT = """
floorplan:
  name: hall
  boundary: [[0, 0], [12, 0], [12, 3], [0, 3]]
  human: {{max_speed: {speed}, max_acceleration: {acceleration}}}
duration: 40.0
rules: observe
people:
  - {{name: a, personality: visitor, at: [5, 1.5], sink: [11, 1.5], beliefs: ["calls(0)"]}}
  - {{name: b, personality: visitor, at: [3, 1.5], sink: [11, 1.5], beliefs: ["calls(0)"]}}
"""


@pytest.mark.parametrize(
    ("speed", "acceleration", "walks"),
    [(1.0, 2.5, True), (1.3, 1.0, True), (2.5, 1.0, False)],
)
def test_a_person_leaves_the_floor_at_full_speed(speed, acceleration, walks):
    """The exception is a person who would begin to brake too far from the door.

    The second may follow the first at a lower speed, from which braking takes less than 1 m.
    """
    run = sim.run(sim.Trial.parse(OUT.format(speed=speed, acceleration=acceleration)))
    assert run.summary["left"] == 2
    first, second = (
        float(np.hypot(*run.motions[event["person"]].velocity(event["t"] - 1e-3)))
        for event in events(run, "left")
    )
    assert first == pytest.approx(speed if walks else 0.0, abs=0.01)
    if walks:
        assert second == pytest.approx(speed, abs=0.01)
    assert second**2 / (2 * acceleration) < 1.0


def test_a_group_waits_for_a_leader_who_comes_later():
    """The followers of an absent leader start on the floor."""
    tour = """people:
  - name: guide
    personality: visitor
    source: {at: gate, rate: 1, count: 1}
    sink: [6, 3]
    group: tour
  - {name: tourist, count: 2, home: [6, 1], at: anywhere, group: tour, sink: [2, 5]}
"""
    text = DOORS.split("people:")[0] + tour
    run = sim.run(sim.Trial.parse(text))
    assert all(0 < run.motions[f"tourist{k}"].position(0.0)[0] < 12 for k in (1, 2))
    came = events(run, "entered")[0]["t"]
    walked = events(run, "walks_with")
    assert {e["person"] for e in walked} == {"tourist1", "tourist2"}
    assert all(came <= e["t"] < came + 2 for e in walked[:2])
    assert run.summary["overlaps"] == 0 and run.summary["left"] == 3
    assert events(run, "left")[0]["person"] == "guide1"


SHUT = """floorplan:
  boundary: [[0, 0], [14, 0], [14, 8], [0, 8]]
  stations: {west: [2, 4], east: [12, 4]}
  safe_zone: {at: [2, 2]}
  obstacles:
    south: {x: [6.9, 7.1], y: [0, 3.5], z: [0, 2.5]}
    north: {x: [6.9, 7.1], y: [4.5, 8], z: [0, 2.5]}
  doors: {gate: {between: [[7, 3.5], [7, 4.5]]}}
duration: 60
doors: {gate: {closed: [[4, 20]]}}
people:
  - {name: guide, group: tour, at: [5, 4], beliefs: ["bound_for(east)"]}
  - {name: tourist, group: tour, at: [1, 4]}
"""


def test_a_door_that_parts_a_group_holds_it_up_until_it_opens():
    """A follower without a path to the leader tries again every second, and finally joins them."""
    run = sim.run(sim.Trial.parse(SHUT))
    tried = [e["t"] for e in events(run, "path_blocked") if e["person"] == "tourist"]
    assert 8 < len(tried) < 20 and all(4 <= t < 20 for t in tried)
    apart = [math.dist(*(run.motions[n].position(t) for n in run.motions)) for t in (35, 45, 55)]
    assert max(apart) < 5.0


VISITORS = """
floorplan: ariac2023
duration: 120.0
seed: {seed}
people:
  - name: visitor
    personality: visitor
    source: {{at: station1, rate: 0.2, count: 10}}
    sink: [-10.0, 3.75]
    beliefs: ["calls({calls})"]
gantry: {{controller: {controller}}}
"""


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_visitors_leave_whatever_the_gantry_does_to_them(seed):
    """After a violation visitors continue with the rest of their calls, and never start again.

    Only an arrival at the call or a violation leads to another goal, which is the exit. The
    shortest path to the exit passes the gantry at little more than the distance of a violation. A
    visitor who walks beside another one may therefore cause a violation on it too, and start for
    the exit again.
    """
    run = sim.run(sim.Trial.parse(VISITORS.format(seed=seed, calls=1, controller="parked")))
    assert run.summary["penalties"] > 0
    assert run.summary["entered"] == run.summary["left"] == 10
    for name in run.summary["people"]:
        goals = [e["at"] for e in events(run, "goal") if e["person"] == name]
        hits = [e for e in events(run, "violation") if e["person"] == name]
        calls = [e for e in events(run, "arrived") if e["person"] == name and e["at"] == goals[0]]
        assert [tuple(goal) for goal in goals[1:]] == [(-10.0, 3.75)] * (len(calls) + len(hits))
        assert len(calls) + len(hits) >= 1 and len(calls) <= 1


def test_visitors_call_on_stations_that_they_have_not_seen_yet():
    """A visitor calls on all four stations before repeating one, despite violations."""
    run = sim.run(sim.Trial.parse(VISITORS.format(seed=1, calls=5, controller="parked")))
    stations = {tuple(s.position) for s in run.floorplan.stations}
    toured = 0
    for name in run.summary["people"]:
        goals = [tuple(e["at"]) for e in events(run, "goal") if e["person"] == name]
        first = [goal for goal in goals if goal in stations][:4]
        assert len(set(first)) == len(first)
        toured += len(first) == 4
    assert toured > 0


def test_followers_leave_after_a_violation_without_their_leader():
    """Followers moved home on their way out start again for the exit, not for a station."""
    text = (
        VISITORS.format(seed=1, calls=0, controller="parked").split("people:")[0]
        + """
people:
  - {name: guide, personality: visitor, at: [-10.0, 2.5], sink: [-10.0, 3.75], group: tour}
  - {name: tourist, group: tour, at: [-10.8, 3.0], sink: station3}
"""
    )
    run = sim.run(sim.Trial.parse(text))
    assert any(e["person"] == "tourist" for e in events(run, "violation"))
    assert run.summary["left"] == 2


@pytest.mark.parametrize(
    ("people", "between"),
    [
        (
            "{name: v, personality: visitor, source: {at: gate, rate: 0.001, count: 3}, sink: out}",
            None,
        ),
        (
            "{name: a, personality: external, at: [1, 5]}\n"
            "  - {name: b, personality: external, at: [11, 1]}\n"
            "  - {name: v, personality: visitor, source: {at: gate, rate: 0.001, count: 3}}",
            {"a", "b"},
        ),
        (
            "{name: a, personality: external, at: [1, 5]}\n"
            "  - {name: v, personality: visitor, source: {at: gate, rate: 9, count: 1}, sink: out}",
            {"a", "v1"},
        ),
    ],
)
def test_only_people_on_the_floor_have_distances(people, between):
    """Absent people are 10 m apart, which may be closer than any people on a large floor."""
    run = sim.run(sim.Trial.parse(f"{TRIAL.split('people:')[0]}people:\n  - {people}\n"))
    nearest = run.summary["nearest_people"]
    assert run.summary["overlaps"] == 0
    if between is None:
        assert nearest is None
        return
    assert set(nearest["between"]) == between
    ends = [run.presence[name] for name in nearest["between"]]
    begin, end = max(a for a, _ in ends), min(b for _, b in ends)
    motions = [run.motions[name] for name in nearest["between"]]
    t, apart = navigation.minimum_separation(*motions, begin, end - 1e-9)
    assert nearest["distance"] == pytest.approx(apart - 0.6, abs=1e-6)
    assert nearest["time"] == pytest.approx(t, abs=1e-3)
