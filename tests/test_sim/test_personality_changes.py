"""People whose personality changes in the course of a trial."""

import pytest
from run_events import events, first, said

import bdi
import sim

PATROL = """
floorplan: ariac2023
duration: 60
people:
  - name: operator
    personality: indifferent
    changes: [{change}]
gantry: {{at: [-2.5, 0.5, 0.0]}}
"""


def trial(change, folder=".", text=PATROL):
    return sim.Trial.parse(text.format(change=change), folder=folder)


def test_a_personality_changes_at_a_time_and_the_person_walks_on(tmp_path):
    """The change is on the way to the second station, where the new agent walks on."""
    run = sim.run(trial("{when: {time: 10.0}, personality: helpful}"))
    plain = sim.run(trial(""))
    (changed,) = events(run, "personality_changed")
    assert (changed["t"], changed["person"], changed["personality"]) == (10, "operator", "helpful")
    bound_for = [event["station"] for event in events(plain, "goal") if event["t"] < 10.0][-1]
    goal = first(run, "goal", after=10.0)
    assert (goal["t"], goal["station"]) == (10.0, bound_for)
    before, later = run.motions["operator"].state_before(10.0), run.motions["operator"].state(10.0)
    assert before.at == later.at
    assert later.speed == pytest.approx(before.speed)
    # The helpful agent turns round at the gantry, the indifferent one never does.
    turned = first(run, "goal", after=events(run, "gantry_detected")[0]["t"] + 1e-6)
    assert turned["station"] != first(plain, "goal", after=turned["t"])["station"]
    assert run.summary["people"]["operator"]["personality"] == "indifferent"


def test_a_personality_changes_after_an_event(tmp_path):
    """The person is antagonistic at first, and just stands after the second violation."""
    (tmp_path / "rest.asl").write_text("+human_start <- .print(resting).\n")
    text = PATROL.replace("indifferent", "antagonistic").replace("duration: 60", "duration: 120")
    change = "{when: {event: violation, count: 2}, personality: rest.asl}"
    run = sim.run(trial(change, tmp_path, text))
    second = events(run, "violation")[1]["t"]
    (changed,) = events(run, "personality_changed")
    (said,) = events(run, "said")
    assert changed["t"] == said["t"] == second
    assert len(events(run, "violation")) == 2
    assert [event for event in events(run, "goal") if event["t"] > second] == []
    # The rules put the person into the safe zone, although the new agent did not request it.
    assert [event["t"] for event in events(run, "teleport")] == [
        event["t"] for event in events(run, "violation")
    ]
    assert run.motions["operator"].position(120.0) == pytest.approx((-15.0, -10.0))


def test_the_new_agent_gets_percepts_of_the_same_time_and_no_older_ones(tmp_path):
    (tmp_path / "tells.asl").write_text(
        "+gantry_disabled(N) <- .print(disabled, N).\n+gantry_detected(N) <- .print(detected, N).\n"
        "+work_completed(N) <- .print(completed, N).\n"
    )
    change = "{when: {event: violation}, personality: tells.asl}"
    run = sim.run(trial(change, tmp_path))
    violation = events(run, "violation")[0]["t"]
    said = [(event["t"], event["text"]) for event in events(run, "said")]
    assert said[0] == (violation, "disabled0")
    assert "detected0" not in [text for _, text in said]


def test_counters_continue(tmp_path):
    (tmp_path / "walks.asl").write_text(
        "+human_start <- move(-10.8, -3.75, 0).\n+work_completed(N) <- .print(completed, N).\n"
    )
    arrivals = [event["t"] for event in events(sim.run(trial("")), "arrived")]
    when = (arrivals[1] + arrivals[2]) / 2
    run = sim.run(trial(f"{{when: {{time: {when}}}, personality: walks.asl}}", tmp_path))
    assert said(run) == ["completed2"]


def test_a_change_of_personality_drops_the_current_errand(tmp_path):
    (tmp_path / "chatty.asl").write_text(
        "!talk. +!talk <- walk_speed(0.4); move(-10.8, -3.75, 0); !on. "
        "+!on <- .wait(1000); .print(hello); !on.\n"
    )
    (tmp_path / "silent.asl").write_text("+work_completed(_) <- .print(surprise).\n")
    text = PATROL.replace("indifferent", "chatty.asl")
    run = sim.run(trial("{when: {time: 5.5}, personality: silent.asl}", tmp_path, text))
    assert [event["t"] for event in events(run, "said")] == [1, 2, 3, 4, 5]
    assert run.motions["operator"].state(6.5).speed == 0.0
    assert events(run, "arrived") == []


def test_a_program_is_swapped_while_the_simulation_runs(tmp_path):
    simulation = sim.Simulation(trial(""))
    simulation.advance(12.0)
    person = simulation.person("operator")
    person.change_personality(bdi.parse("+human_start <- move(-15, -10, 0)."))
    simulation.advance(30.0)
    (tmp_path / "back.asl").write_text("+human_start <- walk_speed(0.5); move(-10.8, -3.75, 0).\n")
    person.change_personality(tmp_path / "back.asl")
    simulation.advance(60.0)
    run = simulation.finish()
    assert [event["t"] for event in events(run, "personality_changed")] == [12.0, 30.0]
    goals = [event["at"] for event in events(run, "goal") if event["t"] >= 12.0]
    assert goals == [[-15, -10], [-10.8, -3.75]]
    with pytest.raises(sim.TrialError, match="did you mean 'helpful'"):
        person.change_personality("helpfull")
    with pytest.raises(ValueError, match="'oprator'; did you mean 'operator'"):
        simulation.person("oprator")


def test_random_draws_are_new_after_a_change_and_the_same_each_time(tmp_path):
    (tmp_path / "dice.asl").write_text("!go. +!go <- .random(R); .print(R).\n")
    text = PATROL.replace("indifferent", "dice.asl").replace("duration: 60", "duration: 3")
    change = "{when: {time: 1.0}, personality: dice.asl}"
    runs = [sim.run(trial(change, tmp_path, text)) for _ in range(2)]
    thrown = [said(run) for run in runs]
    assert thrown[0] == thrown[1]
    assert len(set(thrown[0])) == 2


def test_the_new_agent_hears_other_people(tmp_path):
    (tmp_path / "asks.asl").write_text("!go. +!go <- .wait(5000); .send(operator, tell, hello).\n")
    (tmp_path / "hears.asl").write_text("+hello[source(S)] <- .print(S).\n")
    text = PATROL.replace("gantry:", "  - {{name: other, personality: asks.asl}}\ngantry:")
    run = sim.run(trial("{when: {time: 1.0}, personality: hears.asl}", tmp_path, text))
    assert [(event["t"], event["text"]) for event in events(run, "said")] == [(5.0, "other")]


def test_a_person_starts_when_another_has_arrived():
    text = PATROL.replace(
        "gantry:", "  - {{name: b, start: {{event: arrived, person: operator, count: 2}}}}\ngantry:"
    )
    run = sim.run(trial("", text=text))
    second = [event["t"] for event in events(run, "arrived") if event["person"] == "operator"][1]
    started = [event["t"] for event in events(run, "human_started") if event["person"] == "b"]
    assert started == [second]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("{personality: helpful}", "changes[0].when: is missing"),
        ("{when: {time: 1}, personality: helpfull}", "changes[0].personality: no personality"),
        ("{when: {}, personality: helpful}", "give one of time, part_placed, order_submitted, ev"),
        (
            "{when: {time: 1, count: 2}, personality: helpful}",
            "count and person belong to an ev",
        ),
        ("{when: {event: violatoin}, personality: helpful}", "did you mean 'violation'?"),
        ("{when: {event: goal, count: 0}, personality: helpful}", "count: expected at least 1"),
        ("{when: {event: goal, person: b}, personality: helpful}", "no person is called 'b'"),
        ("{when: {time: 1}, personality: external}", "no personality changes to or from"),
    ],
)
def test_changes_that_make_no_sense_are_reported(change, message):
    with pytest.raises(sim.TrialError) as caught:
        trial(change)
    assert message in "\n".join(str(problem) for problem in caught.value.problems)


def test_a_trial_with_changes_can_be_written_and_read_again():
    first = trial(
        "{when: {time: 1.5}, personality: helpful},"
        " {when: {event: arrived, person: operator, count: 2}, personality: scared}"
    )
    assert sim.Trial.parse(first.to_yaml(".")).people == first.people


def test_the_personality_of_people_who_walk_together_changes():
    text = """
floorplan: warehouse
duration: 5
people:
  - {name: a, count: 2, group: g, changes: [{when: {time: 2}, personality: helpful}]}
"""
    run = sim.run(sim.Trial.parse(text))
    changed = events(run, "personality_changed")
    assert [(one["t"], one["person"]) for one in changed] == [(2.0, "a1"), (2.0, "a2")]
