"""Gantry controllers beside people: percepts, interrupts and forbidden motions."""

import itertools
import math
import random

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from run_events import events

import navigation
import sim
from navigation.separation import required_at_speeds

STAY = "!stay. +!stay <- .wait(100000); !stay.\n"
WALK = "!go. +!go <- move({x}, {y}, 0.0).\n"


@pytest.fixture
def controller(tmp_path):
    """Return a function that writes a controller into a new module."""
    names = (f"policy_{tmp_path.name}_{k}" for k in itertools.count())

    def make(text):
        name = next(names)
        (tmp_path / f"{name}.py").write_text(text)
        return f"{name}:go"

    return make


def trial(text, folder="."):
    return sim.Trial.parse("floorplan: ariac2023\n" + text, folder=folder)


def kitting(
    personality, controller, seed, rules="paper", people=1, duration=275, speeds=(0.6, 1.4)
):
    """Return a trial with walking people, and a gantry with more parts than it can fetch."""
    chance = random.Random(seed)
    bins, agvs = [f"bin{k}" for k in range(1, 9)], [f"agv{k}" for k in range(1, 5)]
    jobs = [
        f"    - {{pick: {chance.choice(bins)}, place: {chance.choice(agvs)}, part: part{k}}}"
        for k in range(40)
    ]
    persons = [
        f"  - {{name: p{k}, personality: {personality}, start: {{time: {12.0 * k}}},"
        f" max_speed: {chance.uniform(*speeds):.2f}}}"
        for k in range(people)
    ]
    start = f"[{chance.uniform(-12, 0):.2f}, {chance.uniform(-5, 5):.2f}, 0.0]"
    return trial(
        f"duration: {duration}\nrules: {rules}\nseed: {seed}\npeople:\n"
        + "\n".join(persons)
        + f"\ngantry:\n  controller: {controller}\n  at: {start}\n  jobs:\n"
        + "\n".join(jobs)
    )


def too_near_while_moving(run, law):
    """Return the sampled times at which the gantry moves while a person is too close."""
    gantry = run.motions["gantry"]
    ts = np.arange(0.0, run.duration, 0.01)
    robot_speed = np.hypot(*gantry.velocity(ts).T)
    # The referee stops the gantry after a violation, so its controller does not cause that braking.
    stopped = np.zeros(len(ts), dtype=bool)
    for event in events(run, "gantry_disabled"):
        stopped |= (ts >= event["t"]) & (ts < event["t"] + event["seconds"])
    times = []
    for name, person in run.motions.items():
        if not name.startswith("p"):
            continue
        speed = np.hypot(*person.velocity(ts).T)
        distance = np.hypot(*(person.position(ts) - gantry.position(ts)).T)
        required = np.array([law.distance(h, r) for h, r in zip(speed, robot_speed, strict=True)])
        near = (distance < required - 1e-6) & (robot_speed > 1e-3) & ~stopped
        times += ts[near].tolist()
    return times


INTEGRAL = (
    "{name: integral, gantry_law: {iso_ts_15066_integral: {t1: 0.6, t2: 1.0, intrusion: 0.9}}}"
)


@given(
    seed=st.integers(0, 10_000),
    personality=st.sampled_from(["indifferent", "helpful", "antagonistic", "curious"]),
    controller=st.sampled_from(["pausing", "avoiding"]),
    rules=st.sampled_from(["paper", "ariac2023", INTEGRAL]),
    people=st.integers(1, 2),
)
@settings(max_examples=settings.default.max_examples // 16)
def test_careful_controllers_never_move_while_a_person_is_too_near(
    seed, personality, controller, rules, people
):
    run = sim.run(kitting(personality, controller, seed, rules, people, duration=90))
    assert [e for e in events(run, "violation") if e["with"] == "gantry" and e["robot_speed"]] == []
    if rules != INTEGRAL:
        assert too_near_while_moving(run, run.trial.rules.gantry_law) == []


def test_the_oracle_finds_violations_of_an_oblivious_gantry():
    run = sim.run(kitting("indifferent", "oblivious", 3))
    moving = [event for event in events(run, "violation") if event["robot_speed"] > 1e-3]
    assert moving
    # A violation ends as soon as it is reported, but its time is between two samples.
    just_before = [round(event["t"], 2) for event in moving]
    assert len(just_before) == len(moving)


@pytest.mark.parametrize("controller", ["pausing", "avoiding"])
def test_without_people_careful_controllers_are_as_fast_as_the_oblivious_one(controller):
    jobs = "[{pick: bin2, place: agv1}, {pick: bin6, place: agv4}]"
    runs = [
        sim.run(trial(f"duration: 90\ngantry: {{controller: {name}, jobs: {jobs}}}"))
        for name in ("oblivious", controller)
    ]
    ends = [events(run, "job_done")[-1]["t"] for run in runs]
    # Each of the four moves begins after a check of the surroundings, at most 0.1 s later.
    assert ends[0] <= ends[1] <= ends[0] + 0.4 + 1e-6


def test_a_pausing_controller_waits_and_continues_without_the_person(tmp_path):
    (tmp_path / "leave.asl").write_text("!go. +!go <- .wait(20000); move(-15.0, -10.0, 0.0).\n")
    run = sim.run(
        trial(
            """
duration: 90
people: [{name: p, personality: leave.asl, at: [-5.0, 3.75]}]
gantry: {controller: pausing, at: [-1.0, -6.0, 0.0], jobs: [{move: [-2.0, 3.0, 0.0]}]}
""",
            tmp_path,
        )
    )
    assert run.summary["penalties"] == 0
    done = events(run, "job_done")[0]["t"]
    assert done > 20.0
    assert run.motions["gantry"].position(done) == pytest.approx((-2.0, 3.0))
    speed = np.hypot(*run.motions["gantry"].velocity(np.arange(0, done, 0.05)).T)
    assert (speed == 0.0).sum() > 100
    assert set(np.unique(np.round(speed, 3))) & {0.1, 0.25, 0.5}


def test_an_avoiding_controller_does_another_job_when_the_first_is_blocked(tmp_path):
    (tmp_path / "stay.asl").write_text(STAY)
    text = """
duration: 60
people: [{{name: p, personality: stay.asl, at: [-5.0, -3.75]}}]
gantry:
  controller: {}
  at: [-5.0, 3.0, 0.0]
  jobs: [{{pick: bin7, place: agv4, part: blocked}}, {{pick: bin2, place: agv1, part: free}}]
"""
    pausing, avoiding = (
        sim.run(trial(text.format(name), tmp_path)) for name in ("pausing", "avoiding")
    )
    assert [event["part"] for event in events(pausing, "job_done")] == []
    assert [event["part"] for event in events(avoiding, "job_done")] == ["free"]
    assert pausing.summary["penalties"] == avoiding.summary["penalties"] == 0


def test_an_avoiding_controller_detours_around_a_person_on_the_straight_line(tmp_path):
    (tmp_path / "stay.asl").write_text(STAY)
    text = """
duration: 90
people: [{{name: p, personality: stay.asl, at: [-6.0, 0.6]}}]
gantry: {{controller: {}, at: [-12.0, 0.0, 0.0], jobs: [{{move: [0.0, 0.0, 0.0]}}]}}
"""
    pausing, avoiding = (
        sim.run(trial(text.format(name), tmp_path)) for name in ("pausing", "avoiding")
    )
    assert events(pausing, "job_done") == []
    assert len(events(avoiding, "job_done")) == 1
    assert avoiding.summary["minimum_separation"]["distance"] > 3.5


def test_an_avoiding_controller_steps_aside_where_a_pausing_one_waits():
    penalties = {
        name: sum(
            sim.run(kitting("indifferent", name, seed, duration=200, speeds=(0.7, 0.9))).summary[
                "penalties"
            ]
            for seed in range(2)
        )
        for name in ("pausing", "avoiding")
    }
    assert penalties["avoiding"] < penalties["pausing"] / 2


def test_decisions_at_a_time_that_rounds_up_let_time_pass():
    """9.1 is a little less than 8.1 + 1.0."""
    run = sim.run(
        trial(
            """
duration: 60
people: [{name: p, personality: helpful, start: {time: 55}}]
gantry:
  controller: avoiding
  at: [-5.75, -0.64, 0.0]
  jobs: [{pick: bin6, place: agv3}, {pick: bin4, place: agv1}, {pick: bin2, place: agv3}]
"""
        )
    )
    assert run.summary["jobs_done"] == 3


def test_people_are_seen_ten_times_a_second(controller, tmp_path):
    name = controller(
        """
seen = []


def go(gantry):
    yield gantry.wait(0.123)
    for _ in range(5):
        people = yield gantry.look(0.15)
        seen.append((gantry.now, people[0]))
"""
    )
    run = sim.run(
        trial(
            f"duration: 5\npeople: [{{name: p}}]\ngantry: {{controller: '{name}'}}",
            tmp_path,
        )
    )
    seen = __import__(name.partition(":")[0]).seen
    assert [t for t, _ in seen] == pytest.approx([0.3, 0.5, 0.7, 0.9, 1.1])
    person = run.motions["p"]
    for t, sighting in seen:
        assert sighting.name == "p"
        assert sighting.at == pytest.approx(tuple(person.position(t)))
        assert sighting.velocity == pytest.approx(tuple(person.velocity(t)))
        assert sighting.speed == pytest.approx(person.state(t).speed)


def test_a_controller_is_interrupted_after_its_request(controller, tmp_path):
    (tmp_path / "walk.asl").write_text(WALK.format(x=-5.0, y=3.75))
    name = controller(
        """
import simpy

interrupts = []


def go(gantry):
    gantry.interrupt_on("person_close", distance=6.0)
    gantry.interrupt_on("disabled")
    gantry.interrupt_on("enabled")
    while True:
        try:
            yield gantry.wait(1000.0)
        except simpy.Interrupt as interrupt:
            interrupts.append((interrupt.cause, gantry.now))
"""
    )
    run = sim.run(
        trial(
            f"""
duration: 80
people: [{{name: p, personality: walk.asl}}]
gantry: {{controller: '{name}', at: [-5.0, 2.5, 0.0]}}
""",
            tmp_path,
        )
    )
    interrupts = __import__(name.partition(":")[0]).interrupts
    disabled, enabled = events(run, "gantry_disabled")[0], events(run, "gantry_enabled")[0]
    person, gantry = run.motions["p"], run.motions["gantry"]
    near = navigation.first_violation(person, gantry, navigation.FixedDistance(6.0), 0.0, 80.0)
    assert [cause for cause, _ in interrupts[:3]] == ["person_close", "disabled", "enabled"]
    assert [t for _, t in interrupts[:3]] == pytest.approx([near, disabled["t"], enabled["t"]])


def test_a_controller_without_a_request_is_not_interrupted(controller, tmp_path):
    name = controller("def go(gantry):\n    while True:\n        yield gantry.wait(1000.0)\n")
    run = sim.run(
        trial(
            "duration: 100\npeople: [{name: p}]\n"
            f"gantry: {{controller: '{name}', at: [-5.0, 2.5, 0.0]}}",
            tmp_path,
        )
    )
    assert events(run, "gantry_disabled")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("gantry.interrupt_on('lunch')", "nothing called 'lunch' interrupts"),
        ("gantry.interrupt_on('person_close')", "must be a finite number, not inf"),
        ("{}['oops']", "KeyError: 'oops'"),
        ("raise LookupError", "LookupError$"),
        ("yield gantry.look(-1)", "at least 0, not -1"),
        ("yield gantry.move_to(-5, 0, speed_share=0)", "speed_share must be more than 0"),
    ],
)
def test_a_wrong_request_is_reported_with_its_line(controller, tmp_path, line, message):
    name = controller(f"def go(gantry):\n    yield gantry.wait(1)\n    {line}\n")
    with pytest.raises(sim.ControllerError, match=message) as caught:
        sim.run(trial(f"duration: 20\ngantry: {{controller: '{name}'}}", tmp_path))
    assert "line 3" in str(caught.value)


def test_a_new_move_replaces_the_old_one(controller, tmp_path):
    name = controller(
        """
def go(gantry):
    gantry.move_to(-2.0, 0.0)
    yield gantry.wait(2.0)
    yield gantry.move_to(-9.0, 1.0, speed_share=0.5)
    yield gantry.wait(1.0)
    gantry.move_to(-5.0, 1.0)
    yield gantry.wait(1.5)
    yield gantry.stop()
    assert gantry.state.speed == 0
"""
    )
    run = sim.run(trial(f"duration: 60\ngantry: {{controller: '{name}'}}", tmp_path))
    gantry = run.motions["gantry"]
    ts = np.arange(0, 60, 0.001)
    assert np.abs(np.diff(gantry.position(ts), axis=0)).max() < 1.1e-3
    assert np.abs(np.diff(gantry.velocity(ts), axis=0)).max() < 0.6e-3
    turned = gantry.position(ts)[:, 0].min()
    assert turned == pytest.approx(-9.0)
    assert -9.0 < gantry.position(60.0)[0] < -5.0


def test_a_move_that_is_not_to_resume_ends_when_the_gantry_is_disabled(controller, tmp_path):
    (tmp_path / "stay.asl").write_text(STAY)
    name = controller(
        """
def go(gantry):
    yield gantry.wait(5.0)
    yield gantry.move_to(-5.0, 3.0, resume=False)
"""
    )
    run = sim.run(
        trial(
            f"""
duration: 60
people: [{{name: p, personality: stay.asl, at: [-5.0, 3.75]}}]
gantry: {{controller: '{name}', at: [-9.0, 3.75, 0.0]}}
""",
            tmp_path,
        )
    )
    disabled = events(run, "gantry_disabled")[0]["t"]
    stopped = run.motions["gantry"].position([disabled + 3.0, 60.0])
    assert stopped[0] == pytest.approx(stopped[1])
    assert math.dist(stopped[0], (-5.0, 3.0)) > 0.5


def test_a_controller_waits_for_a_place_on_an_agv():
    run = sim.run(
        trial(
            """
duration: 120
gantry: {controller: oblivious, jobs: [{pick: bin2, place: agv1, part: pump}]}
agvs:
  agv1: [{time: 0.0, to: warehouse}, {time: 60.0, to: kitting}]
"""
        )
    )
    back = events(run, "agv_moved")[1]["arrives"]
    (done,) = events(run, "job_done")
    assert done["t"] > back > 60.0
    assert run.motions["gantry"].position(done["t"]) == pytest.approx((-2.27, 4.8))


def test_the_times_of_a_gantry_add_up():
    run = sim.run(trial("duration: 60\ngantry: {controller: oblivious, jobs: [{wait: 10.0}]}"))
    assert run.summary["gantry_idle_time"] == pytest.approx(50.0)
    run = sim.run(kitting("indifferent", "oblivious", 1))
    gantry = run.motions["gantry"]
    ts = np.arange(0.0, 275.0, 0.01)
    moving = (np.abs(gantry.velocity(ts)) > 0).any(axis=1).mean() * 275.0
    handled = 4.0 * run.summary["jobs_done"]
    idle = run.summary["gantry_idle_time"]
    assert idle >= 0.0
    assert moving + handled + idle <= 275.0 + 4.0


def test_a_predictive_law_is_evaluated_at_the_top_speed(controller, tmp_path):
    name = controller(
        """
import sim

distances = []


def go(gantry):
    caution = sim.Caution(gantry)
    distances.extend([caution.required(0.0), caution.required(1.0)])
    yield gantry.wait(1.0)
"""
    )
    text = f"duration: 2\nrules: {INTEGRAL}\ngantry: {{controller: '{name}'}}"
    law = sim.run(trial(text, tmp_path)).trial.rules.gantry_law
    top = required_at_speeds(law, 1.0, math.sqrt(2.0))
    distances = __import__(name.partition(":")[0]).distances
    assert distances[0] == distances[1] > top


def test_no_part_is_handled_from_a_distance_or_twice(controller, tmp_path):
    name = controller(
        """
answers = []


def go(gantry):
    task = yield gantry.next_task()
    answers.append((yield gantry.handle(task)))
    x, y, _ = yield gantry.locate(task)
    yield gantry.move_to(x, y)
    answers.append((yield gantry.handle(task)))
    answers.append(task.finished)
    yield gantry.handle(task)
"""
    )
    text = f"duration: 30\ngantry: {{controller: '{name}', jobs: [{{move: [-5, 0, 0]}}]}}"
    with pytest.raises(sim.ControllerError, match="is done already"):
        sim.run(trial(text, tmp_path))
    assert __import__(name.partition(":")[0]).answers == [False, True, True]
