"""Recorded people: the sources of their tracks, and other people beside them."""

import math

import numpy as np
import pytest

import navigation
import sim

HALL = """\
floorplan:
  boundary: [[0, 0], [20, 0], [20, 10], [0, 10]]
  stations: {west: [1, 5], east: [19, 5]}
  safe_zone: {at: [1, 1]}
"""


def straight(name="eve", begin=(1.0, 5.0), speed=1.2, until=15.0, step=0.5):
    """Return rows of a person who walks along x, t = 0 first."""
    times = np.arange(0.0, until + 1e-9, step)
    return [f"{t:.3f},{name},{begin[0] + speed * t:.6f},{begin[1]:.6f}" for t in times]


def tracks(folder, *rows, header="t,name,x,y", file="tracks.csv"):
    (folder / file).write_text("\n".join([header, *rows]) + "\n")


def trial(folder, text, floor=HALL):
    return sim.Trial.parse(floor + text, folder=folder)


def sampled(run, name, times):
    return run.motions[name].position(np.array(times))


def test_recorded_people_walk_through_their_samples_from_the_start(tmp_path):
    rng = np.random.default_rng(3)
    times = np.cumsum(rng.uniform(0.05, 0.4, 60))
    places = np.column_stack([2 + 0.6 * times, 5 + np.sin(times)])
    tracks(
        tmp_path,
        *(
            f"{t!r},eve,{x!r},{y!r}"
            for t, (x, y) in zip(times.tolist(), places.tolist(), strict=True)
        ),
    )
    run = sim.run(
        trial(
            tmp_path,
            "duration: 40\npeople: [{name: eve, recorded: tracks.csv, start: {time: 5}}]\n",
        )
    )
    assert np.allclose(sampled(run, "eve", times + 5.0), places, atol=1e-9)
    (person,) = run.summary["people"].values()
    assert person["personality"] == "recorded" and person["started"] == 5.0
    oracle = navigation.Motion.from_samples(times, places)
    places = oracle.position(np.linspace(times[0], times[-1], 200_001))
    length = np.hypot(*np.diff(places, axis=0).T).sum()
    assert person["distance_walked"] == pytest.approx(length, rel=1e-6)


def test_the_monitor_watches_recorded_people_like_others(tmp_path):
    """The violations are those of the same motion alone, however often others look ahead."""
    tracks(tmp_path, *straight("eve", (-14.0, 0.0), 1.3, 10.0))
    entry = sim.Trial.parse(
        """\
floorplan: ariac2023
duration: 30
rules: paper
people: [{name: eve, recorded: tracks.csv}]
gantry: {controller: parked, at: [-5.0, 2.0, 0.0]}
""",
        folder=tmp_path,
    )
    run = sim.run(entry)
    times = np.arange(0.0, 10.01, 0.5)
    walk = navigation.Motion.from_samples(times, np.column_stack([-14 + 1.3 * times, 0 * times]))
    gantry = navigation.standing((-5.0, 2.0))
    expected = navigation.violations(walk, gantry, entry.rules.gantry_law, 0.0, 30.0)
    intervals = run.violations["eve", "gantry"]
    assert len(expected) > 0 and np.allclose(intervals, expected, atol=1e-3)
    assert not [event for event in run.events if event["kind"] == "teleport"]


ENDS_IN_MOTION = """\
floorplan: ariac2023
duration: 30
people: [{name: eve, recorded: tracks.csv}]
"""

OWN_LAWS = """\
from navigation import Enclosure

class OfSpeeds:
    def distance(self, human_speed, robot_speed):
        return 0.5 + 2.0 * human_speed + robot_speed

class OfMotions:
    def required(self, encounter, begin, end):
        human = encounter.human_speed(begin, end)
        return Enclosure(
            value=0.5 + 2.0 * human.value, slope=2.0 * human.slope, slack=2.0 * human.slack
        )
"""


@pytest.mark.parametrize(
    "law",
    [
        "iso_ts_15066: {t1: 1.0, t2: 1.5, intrusion: 1.0}",
        "own_laws:OfSpeeds: {}",
        "own_laws:OfMotions: {}",
    ],
)
def test_a_violation_ends_with_a_track_that_ends_in_motion(tmp_path, law):
    """Each of these laws requires less than the remaining 1.7 m beside a person who stands."""
    (tmp_path / "own_laws.py").write_text(OWN_LAWS)
    tracks(tmp_path, *straight("eve", (-12.0, 0.0), 1.0, 4.0))
    tracked = trial(
        tmp_path,
        f"rules: {{based_on: observe, name: ours, gantry_law: {{{law}}}}}\n"
        "gantry: {controller: parked, at: [-6.3, 0, 0]}\n",
        ENDS_IN_MOTION,
    )
    run = sim.run(tracked)
    expected = navigation.violations(
        run.motions["eve"], run.motions["gantry"], tracked.rules.gantry_law, 0.0, 30.0
    )
    assert expected[-1][1] == 4.0
    assert np.allclose(run.violations["eve", "gantry"], expected, rtol=0.0, atol=1e-6)


def test_a_protective_stop_ends_with_a_track_that_ends_in_motion(tmp_path):
    tracks(tmp_path, *straight("eve", (-12.0, 0.0), 1.0, 3.0))
    run = sim.run(
        trial(
            tmp_path,
            "rules: protective_stop\ngantry: {controller: parked, at: [-6.4, 0, 0]}\n",
            ENDS_IN_MOTION,
        )
    )
    stops = [
        (e["kind"], round(e["t"], 6)) for e in run.events if e["kind"].startswith("protective_stop")
    ]
    assert stops == [("protective_stop", 2.1), ("protective_stop_ended", 3.0)]


def test_others_walk_round_recorded_people_and_step_aside(tmp_path):
    tracks(tmp_path, *straight("eve"), *straight("max", (1.0, 6.5), 0.9))
    (tmp_path / "go.asl").write_text("+human_start <- move(1.0, 5.2, 0).")
    run = sim.run(
        trial(
            tmp_path,
            """\
duration: 30
people:
  - {name: eve, recorded: tracks.csv}
  - {name: max, recorded: tracks.csv}
  - {name: meets, personality: go.asl, at: [18, 5.1]}
  - {name: rests, personality: external, at: [10, 5.2]}
""",
        )
    )
    assert run.summary["overlaps"] == 0
    assert np.allclose(sampled(run, "eve", [3.0, 10.0]), [[4.6, 5.0], [13.0, 5.0]])
    assert math.dist(*sampled(run, "rests", [0.0, 30.0])) > 0.3
    assert math.dist(sampled(run, "meets", 30.0), (1.0, 5.2)) < 1e-6


def test_a_recording_can_be_walked_again(tmp_path):
    """The same people walk the same paths from what their run exported, in either format."""
    first = sim.run(
        trial(
            tmp_path,
            """\
duration: 20
people:
  - {name: eve, personality: indifferent, at: [1, 5]}
  - {name: max, personality: indifferent, at: [19, 4]}
""",
        )
    )
    times = np.arange(0.0, 20.0, 0.35)
    sim.export(first, tmp_path / "run.csv", rate=20.0)
    sim.export(first, tmp_path / "run.sqlite", rate=20.0)
    for file in ("run.csv", "run.sqlite"):
        again = sim.run(
            trial(
                tmp_path,
                f"duration: 20\npeople: [{{name: eve, recorded: {file}}},"
                f" {{name: max2, recorded: {{file: {file}, body: max}}}}]\n",
            )
        )
        for name, before in (("eve", "eve"), ("max2", "max")):
            apart = sampled(again, name, times) - sampled(first, before, times)
            assert np.hypot(*apart.T).max() < 0.01


PUT_HOME = """\
floorplan:
  boundary: [[0, 0], [24, 0], [24, 10], [0, 10]]
  safe_zone: {at: [2, 2]}
  stations: {west: [6, 8], east: [14, 8], out: [16, 5]}
  patrol: [east, west]
  agvs:
    size: [2.0, 0.8]
    height: 1.0
    max_speed: 1.5
    max_acceleration: 1.0
    limits: [0, 16]
    locations: {home: 0, gate: 8}
    start: home
    lanes: {cart: {origin: [4, 1.1], heading: 0.0}}
duration: 45
"""
PUT_HOME_PEOPLE = """\
people:
  - {name: eve, personality: indifferent, start: {time: 1.0}}
  - {name: max, personality: indifferent, at: [3, 3], start: {time: 1.0}}
  - name: ann
    personality: visitor
    source: {at: west, rate: 0.2, count: 2}
    sink: out
    beliefs: ["calls(1)"]
agvs: {cart: [{time: 24.03, to: 0.5}, {time: 36.517, to: 0}]}
rules: {based_on: paper, agv_law: {fixed: 40.0}}
"""


@pytest.fixture(scope="module")
def put_home(tmp_path_factory):
    """A run in which all people are put home twice, and all its files."""
    folder = tmp_path_factory.mktemp("written")
    recording = sim.Recording(folder / "run")
    run = sim.run(sim.Trial.parse(PUT_HOME + PUT_HOME_PEOPLE), recording)
    recording.finish(run)
    for name in ("run.csv", "run.parquet", "run.sqlite", "run.mcap", "bag"):
        sim.export(run, folder / name, rate=20.0)
    return run, folder


@pytest.mark.parametrize(
    ("file", "rate", "accuracy"),
    [
        ("run/trajectory.csv", 10.0, 1e-6),
        ("run.csv", 20.0, 1e-6),
        ("run.parquet", 20.0, 1e-12),
        ("run.sqlite", 20.0, 1e-12),
        ("run.mcap", 20.0, 1e-12),
        ("bag", 20.0, 1e-12),
    ],
)
def test_all_files_of_a_run_can_be_walked_again(put_home, file, rate, accuracy):
    """They pass all samples, and teleports home are the jumps of the run."""
    first, folder = put_home
    names = [name for name in first.motions if name != "cart"]
    people = ", ".join(f"{{name: {name}, recorded: {file}}}" for name in names)
    again = sim.run(sim.Trial.parse(f"{PUT_HOME}people: [{people}]\n", folder=folder))
    for name in names:
        begin, end = first.presence[name]
        jumps = sorted(t for t in first.motions[name].jumps if begin < t < end)
        assert len(jumps) == 2 if name in ("eve", "max") else end < first.duration
        if not file.endswith(".sqlite"):  # this format has frames only
            inside = sorted(t for t in again.motions[name].jumps if begin + 1e-6 < t < end - 1e-6)
            assert inside == pytest.approx(jumps, abs=1e-9)
        if file in ("run.mcap", "bag"):  # these formats have the jumps onto the floor and off it
            assert again.presence[name] == pytest.approx((begin, end), abs=1e-8)
        times = np.arange(0.0, 45.0 + 1e-9, 1 / rate)
        times = times[(times >= begin) & (times < end)]
        apart = sampled(again, name, times) - sampled(first, name, times)
        assert np.hypot(*apart.T).max() < accuracy
        between = np.arange(begin + 0.5 / rate, end - 1 / rate, 0.37 / rate)
        apart = sampled(again, name, between) - sampled(first, name, between)
        assert np.hypot(*apart.T).max() < 0.08


def test_two_samples_at_one_time_are_a_jump(tmp_path):
    rows = [f"{t},eve,{1 + t},5" for t in (0.0, 0.5, 1.0)]
    rows += [f"{t},eve,{10 + t},2" for t in (1.0, 1.5, 2.0)]
    tracks(tmp_path, *rows)
    run = sim.run(trial(tmp_path, "duration: 3\npeople: [{name: eve, recorded: tracks.csv}]\n"))
    motion = run.motions["eve"]
    assert motion.jumps == {1.0}
    assert np.allclose(motion.state_before(1.0).at, (2, 5))
    assert np.allclose(
        motion.position([0.9, 1.0, 1.1, 2.5]), [[1.9, 5], [11, 2], [11.1, 2], [12, 2]]
    )
    assert run.summary["people"]["eve"]["distance_walked"] == pytest.approx(2.0)


def test_the_same_sample_twice_is_no_jump(tmp_path):
    rows = straight()
    tracks(tmp_path, *rows[:5], *rows[4:])
    run = sim.run(trial(tmp_path, "people: [{name: eve, recorded: tracks.csv}]\nduration: 10\n"))
    assert not run.motions["eve"].jumps
    assert np.allclose(sampled(run, "eve", 5.0), (7.0, 5.0))


def test_frames_of_pedpy_are_read_in_their_unit(tmp_path):
    lines = ["# description: a corridor", "# framerate: 25.00", "# id frame x/cm y/cm z/cm"]
    lines += [f"7 {k} {100 + 4 * k} 500 170" for k in range(100)]
    (tmp_path / "corridor.txt").write_text("\n".join(lines))
    run = sim.run(
        trial(
            tmp_path,
            "duration: 6\n"
            "people: [{name: eve, recorded: {file: corridor.txt, body: 7, since: 1}}]\n",
        )
    )
    assert np.allclose(sampled(run, "eve", [0.0, 1.0]), [[2.0, 5.0], [3.0, 5.0]])


def test_the_trial_is_written_and_read_again(tmp_path):
    tracks(tmp_path, *straight())
    before = trial(tmp_path, "people: [{name: eve, recorded: {file: tracks.csv, since: 2.0}}]\n")
    assert sim.Trial.parse(before.to_yaml(tmp_path), folder=tmp_path).people == before.people
    walk = navigation.Motion.from_samples([0.0, 10.0], [(1.0, 5.0), (9.0, 5.0)])
    run = sim.run(
        sim.Trial(before.floorplan, duration=9.0, people=(sim.PersonEntry("eve", recorded=walk),))
    )
    assert np.allclose(sampled(run, "eve", 5.0), (5.0, 5.0))


GOOD = straight()
BAD = {
    "a gap": ([*GOOD[:4], *GOOD[9:]], "line 6: a gap of 3 s: there is nothing from t = 1.5 s on"),
    "a jump": ([*GOOD[:3], "1.5,eve,9,5", *GOOD[4:]], "line 5: a jump of 6.8 m in 0.5 s"),
    "a jump that is not stated": (
        [*GOOD[:3], "1.5,eve,9,5", *GOOD[4:]],
        "or state the jump by two samples at one time, one before it and one after it",
    ),
    "many at one time": (
        [*GOOD[:3], *3 * [GOOD[2]], *GOOD[3:]],
        "line 7: t = 1 s is not after the",
    ),
    "backwards": ([*GOOD[:3], *GOOD[1:]], "line 5: t = 0.5 s is not after the 1 s of line 4"),
    "no number": ([*GOOD[:2], "1.0,eve,?,5"], "line 4: x must be a number, found '?'"),
    "cut off": ([*GOOD[:2], "1.0,eve"], "line 4: has 2 columns, and none for x"),
    "another body": (
        straight("max") + straight("mo"),
        "no body is called 'eve'; there are: max",
    ),
    "millimetres": (["0,eve,1000,5000", "1,eve,1001,5000"], "line 2: (1000, 5000) is outside"),
    "another clock": (["1700000000,eve,1,5", "1700000001,eve,2,5"], "line 2: the track begins at"),
    "nothing": ([], "is empty"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_tracks_are_rejected_with_their_row(tmp_path, name):
    rows, message = BAD[name]
    tracks(tmp_path, *rows)
    with pytest.raises(sim.TrialError) as refused:
        trial(tmp_path, "people:\n  - {name: eve, recorded: tracks.csv}\n")
    assert message in str(refused.value)
    assert "tracks.csv" in str(refused.value) and refused.value.problems[0].line == 6


def test_invalid_keys_of_recorded_people_are_errors(tmp_path):
    with pytest.raises(sim.TrialError, match="omit at, personality"):
        trial(tmp_path, "people: [{name: e, recorded: t.csv, personality: scared, at: [1, 1]}]\n")
    with pytest.raises(sim.TrialError, match="there is no such file"):
        trial(tmp_path, "people: [{name: e, recorded: t.csv}]\n")
    (tmp_path / "t.csv").write_text("id,frame,x,y\n1,0,1,1\n1,1,1,1\n")
    with pytest.raises(sim.TrialError, match="give frame_rate"):
        trial(tmp_path, "people: [{name: e, recorded: t.csv}]\n")
    (tmp_path / "t.csv").write_text("x,y\n1,1\n")
    with pytest.raises(sim.TrialError, match="no column name"):
        trial(tmp_path, "people: [{name: e, recorded: t.csv}]\n")


AISLE = """\
floorplan:
  boundary: [[0, 0], [8, 0], [8, -2], [14, -2], [14, 3], [8, 3], [8, 0.7], [0, 0.7]]
  stations: {west: [0.4, 0.35], east: [12, 0.35]}
duration: 75
people:
  - {name: eve, recorded: tracks.csv}
  - {name: ada, at: [1.2, 0.35], beliefs: ["bound_for(east)"]}
  - {name: bob, at: [0.4, 0.35], beliefs: ["bound_for(east)"]}
"""


def test_people_behind_a_person_who_will_walk_on_are_no_deadlock(tmp_path):
    """Eve stands in a single-file aisle for a minute. The two behind her do not move meanwhile."""
    tracks(
        tmp_path,
        *(f"{t},eve,3,0.35" for t in range(61)),
        *(f"{t},eve,{t - 57},0.35" for t in range(61, 68)),
        *(f"{t},eve,10,{t - 66.65}" for t in range(68, 70)),
    )
    run = sim.run(sim.Trial.parse(AISLE, folder=tmp_path))
    blocked = {e["person"] for e in run.events if e["kind"] == "blocked" and e["t"] < 20.0}
    assert blocked == {"ada", "bob"}
    assert run.summary["deadlocks"] == 0
    assert np.ptp(sampled(run, "ada", [20.0, 55.0]), axis=0).max() == 0.0
    arrived = {e["person"] for e in run.events if e["kind"] == "arrived"}
    assert arrived == {"ada", "bob"}
