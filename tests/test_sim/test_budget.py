"""The budget of a trial: excessive requests are rejected before anything is created."""

from dataclasses import replace

import pytest

import sim

HALL = """
floorplan:
  name: hall
  boundary: [[0, 0], [10, 0], [10, 8], [0, 8]]
  stations: {a: [2, 2], b: [8, 6]}
  safe_zone: {at: [5, 4]}
duration: 60
"""
CART = "machines: {cart: {kind: agv, origin: [1, 1], limits: [0, 5], moves: [%s]}}"


@pytest.mark.parametrize(
    ("keys", "place", "words"),
    [
        (
            "people: [{name: x, count: 100000000}]",
            "line 8, people[0].count",
            "100,000,000 people are more than the 5,000",
        ),
        (
            "people: [{name: x}, {name: y, source: {at: a, rate: 1, count: 5000}, sink: b}]",
            "people[1].source.count",
            "5,001 people are more than the 5,000",
        ),
        ("duration: 1.0e+9", "line 7, duration", "at most 2,678,400 s (31 days), not 1e+09 s"),
        (
            "duration: 2.0e+6\npeople: [{name: x, count: 60, at: anywhere}]",
            "duration",
            "120,000,000 seconds of all people are more than the 100,000,000",
        ),
        (
            "people: [{name: x, schedule: [{at: a, duration: 1, every: 1.0e-6}]}]",
            "people[0].schedule[0].every",
            "60,000,000 tasks are more than the 100,000",
        ),
        (
            "people: [{name: x, count: 3, at: anywhere,"
            " breaks: [{at: a, duration: 1, every: 0.001, count: 50000}]}]",
            "people[0].breaks[0].every",
            "150,000 tasks",
        ),
        (
            "work: {l: [{at: a, duration: 1, every: 1.0e-6}]}\npeople: [{name: x, work: l}]",
            "work.l[0].every",
            "60,000,000 tasks",
        ),
        (
            "work: {l: {repeat: true, tasks: [{at: a, duration: 1.0e-6}]}}\n"
            "people: [{name: x, work: l}]",
            "work.l.tasks[0].duration",
            "60,000,000 tasks",
        ),
        (
            "rules: {based_on: paper, report_every: 1.0e-6}\npeople: [{name: x}]",
            "rules.report_every",
            "60,000,000 reports to people are more than the 10,000,000",
        ),
        (
            "rules: {based_on: paper, notice: {every: 1.0e-6}}\npeople: [{name: x}]",
            "rules.notice.every",
            "60,000,000 reports to people",
        ),
        (
            CART % "{time: 0, to: 1, every: 1.0e-6}",
            "machines.cart",
            "60,000,000 moves of AGVs are more than the 100,000",
        ),
        (
            "floorplan: ariac2023\nagvs: {agv1: [{time: 0, to: kitting, every: 0.001}],"
            " agv2: [{time: 0, to: kitting, every: 0.001}]}",
            "agvs.agv2",
            "120,000 moves of AGVs",
        ),
        (
            "floorplan: ariac2023\ngantry: {controller: oblivious, repeat: true,"
            " jobs: [{wait: 1.0e-6}, {wait: 1.0e-6}]}",
            "gantry.jobs",
            "60,000,000 jobs",
        ),
    ],
)
def test_an_excessive_value_is_rejected_with_its_place(keys, place, words):
    names = {line.partition(":")[0] for line in keys.splitlines()}
    head = HALL if "floorplan" not in names else "\n\n\n\n\nduration: 60\n"
    text = head.replace("duration: 60\n", "") if "duration" in names else head
    with pytest.raises(sim.TrialError) as refused:
        sim.Trial.parse(f"{text}{keys}\n")
    (problem,) = refused.value.problems
    assert words in problem.message
    assert place in str(problem)


def test_trials_changed_by_a_command_are_checked_against_the_budget():
    trial = sim.Trial.parse(f"{HALL}people: [{{name: x}}]")
    with pytest.raises(sim.TrialError, match="duration: must be at most 2,678,400 s"):
        sim.run(replace(trial, duration=1e9))
    people = tuple(sim.PersonEntry(f"x{k}") for k in range(5001))
    with pytest.raises(sim.TrialError, match="people: 5,001 people are more"):
        sim.run(replace(trial, people=people))


def test_a_trial_just_within_the_budget_is_accepted():
    moves = CART % "{time: 0, to: 1, every: 0.00061}"
    assert sim.Trial.parse(HALL + moves).machines["cart"].keys["moves"][0]["every"] == 0.00061
    tasks = "people: [{name: x, schedule: [{at: a, duration: 1, every: 0.00061}]}]"
    assert sim.Trial.parse(HALL + tasks).people[0].schedule[0].every == 0.00061


def test_a_dense_stream_of_people_enters_in_order():
    text = f"""{HALL.replace("duration: 60", "duration: 20")}
people: [{{name: v, personality: visitor, sink: b, source: {{at: a, rate: 1000, count: 300}}}}]
"""
    run = sim.run(sim.Trial.parse(text))
    entered = [event["person"] for event in run.events if event["kind"] == "entered"]
    assert len(entered) > 20
    assert entered == [f"v{k + 1}" for k in range(len(entered))]
