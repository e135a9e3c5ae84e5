"""The thoughts that are recorded are those of the mind."""

import json

import pytest
from run_events import beliefs_after, events, record

import bdi
import sim
from sim.people.minds import MindInspector

PROGRAM = """
step(10).

+seen(N) : step(S) <- .abolish(step(_)); +step(S + N); !report(N).

@long[atomic]
+!report(N) <- say(N); .wait(2000); +told(N).
"""


def watched(source, **options):
    """An agent whose inspector writes into the list that comes with it."""
    thoughts = []
    inspector = MindInspector("me", thoughts.append)
    agent = bdi.Agent(bdi.parse(source), on_event=inspector.note, **options)
    return agent, inspector, thoughts


def test_the_changes_add_up_to_what_the_agent_believes():
    agent, inspector, thoughts = watched(PROGRAM)
    for t in range(12):
        if t % 3 == 1:
            agent.add_percept(f"seen({t})")
        if t % 3 == 0 and t:
            agent.remove_percept(f"seen({t - 2})")
        agent.advance(float(t))
        inspector.look(float(t), agent)
        assert beliefs_after(thoughts) == {str(b.without_annots()) for b in agent.beliefs}


def test_steps_are_reported_in_their_order_and_with_their_places():
    agent, inspector, thoughts = watched(PROGRAM)
    agent.add_percept("seen(1)")
    agent.advance(1.0)
    inspector.look(1.0, agent)
    (thought,) = thoughts
    assert [step[:2] for step in thought["steps"]] == [
        ["percept", "+seen(1)"],
        ["plan", "+seen(1)"],
        ["plan", "+!report(1)"],
        ["action", "say(1)"],
    ]
    assert [step[2].rpartition(":")[2] for step in thought["steps"] if len(step) > 2] == ["4", "7"]
    assert thought["intends"] == [{"stack": ["+seen(1)", "+!report(1)"], "at": ".wait(2000)"}]


@pytest.mark.parametrize("folder", ["", "programs/", "/a/b/c/", "..\\programs\\", "C:\\"])
def test_a_plan_is_reported_with_the_name_of_its_file_alone(folder):
    thoughts = []
    inspector = MindInspector("me", thoughts.append)
    program = bdi.parse(PROGRAM, f"{folder}mine.asl")
    agent = bdi.Agent(program, on_event=inspector.note)
    agent.add_percept("seen(1)")
    agent.advance(1.0)
    inspector.look(1.0, agent)
    places = [step[2] for step in thoughts[0]["steps"] if step[0] == "plan"]
    assert places == ["mine.asl:4", "mine.asl:7"]


def test_a_thought_that_changes_nothing_is_not_told():
    agent, inspector, thoughts = watched(PROGRAM)
    for t in (1.0, 2.0, 3.0):
        agent.advance(t)
        inspector.look(t, agent)
    assert [thought["t"] for thought in thoughts] == [1.0]


def test_minds_are_looked_into_only_if_somebody_wants_to_know(tmp_path):
    trial = sim.Trial.load("scene_antagonistic")
    assert sim.run(trial).thoughts == ()
    run = record(trial, tmp_path / "run")
    lines = (tmp_path / "run" / "thoughts.jsonl").read_text(encoding="utf-8").splitlines()
    assert [json.loads(line) for line in lines] == list(run.thoughts)
    assert sim.load_run(tmp_path / "run").thoughts == run.thoughts
    arrivals = [event["t"] for event in events(run, "arrived")]
    told = [
        thought["t"]
        for thought in run.thoughts
        if any(step[1].startswith("+work_completed") for step in thought.get("steps", ()))
    ]
    assert [t for t in told if t in arrivals]
    assert set(told) <= set(arrivals)


def test_looking_into_minds_changes_nothing(tmp_path):
    trial = sim.Trial.load("scene_helpful")
    plain = sim.run(trial)
    recording = sim.Recording(tmp_path / "run")
    watched = sim.run(trial, recording)
    recording.close()
    assert watched.events == plain.events
