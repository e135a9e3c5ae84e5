"""Agents of people: percepts, beliefs and their recording, with external code or a program."""

import json

import pytest
from hypothesis import given, settings, strategies as st
from run_events import beliefs_after, events, record

import bdi
import sim
import sim.simulation
from sim.people import population as company
from sim.people.minds import MindInspector, Outside
from sim.people.perception import Percepts, mentioned

OUTSIDE = """
floorplan: ariac2023
duration: 60.0
people: [{name: operator, personality: external, start: {time: 2.0}}]
gantry: {at: [-5.0, 2.0, 0.0]}
"""


def test_a_person_without_a_program_executes_actions_from_outside():
    simulation = sim.Simulation(sim.Trial.parse(OUTSIDE))
    (person,) = simulation.people
    simulation.advance(3.0)
    assert person.act(bdi.parse_literal("move(-10.8, -3.75, 0)"))
    simulation.advance(60.0)
    run = simulation.finish()
    assert run.summary["people"]["operator"]["visits"] == ["station4"]
    goal, arrived = events(run, "goal", "arrived")
    assert (goal["t"], goal["station"]) == (3.0, "station4")
    assert arrived["t"] > 6.0


def test_an_external_agent_cannot_skip_the_safe_zone():
    simulation = sim.Simulation(sim.Trial.parse(OUTSIDE))
    (person,) = simulation.people
    simulation.advance(3.0)
    person.act(bdi.parse_literal("move(-5.0, 3.75, 0)"))
    simulation.advance(60.0)
    kinds = [event["kind"] for event in simulation.finish().events]
    assert kinds.count("violation") == kinds.count("teleport") == 1
    assert kinds.index("violation") < kinds.index("teleport")


def test_percepts_of_an_external_agent_are_processed_in_order():
    calls = []
    outside = Outside(called=lambda: calls.append(outside.take()))
    outside.advance(0.0)
    for percept in ("gantry_at(1, 2)", "gantry_detected(0)"):
        outside.add_percept(bdi.parse_literal(percept))
    outside.advance(1.0)
    outside.advance(2.0)
    assert [[str(percept) for percept in call] for call in calls] == [
        ["gantry_at(1,2)", "gantry_detected(0)"]
    ]


def test_only_the_latest_percept_of_a_kind_is_retained():
    agent = bdi.Agent(bdi.parse(""))
    percepts = Percepts(agent)
    for _ in range(3):
        percepts.count("work_completed")
        agent.advance(agent.now + 1.0)
    percepts.see("at", 1.0, 2.0)
    agent.advance(agent.now + 1.0)
    assert {str(percept) for percept in agent.percepts} == {"work_completed(2)", "at(1,2)"}


def test_check_warns_of_unknown_percepts_and_actions_in_programs(tmp_path, floorwalker):
    (tmp_path / "shy.asl").write_text(
        '{ include("patrol.asl") }\n+gantry_detect(_) <- go_away; let_pass.\n+person_gone(W, _).'
    )
    (tmp_path / "shy.trial.yaml").write_text(
        "floorplan: ariac2023\npeople: [{name: a, personality: shy.asl}, {name: b}]\n"
    )
    done = floorwalker("check", "shy.trial.yaml", cwd=tmp_path)
    assert done.returncode == 0
    said = [line.partition(" ")[2] for line in done.stderr.splitlines() if "shy.asl:2" in line]
    assert said == [
        "nothing adds gantry_detect; did you mean gantry_detected?",
        "there is no action go_away; did you mean move_away?",
        "the action let_pass takes 1 arguments, found 0",
    ]


def test_a_program_receives_only_the_percepts_that_it_mentions():
    walker = bdi.parse("+human_start <- move(1, 2, 0).")
    assert mentioned(walker) == frozenset()
    assert mentioned(bdi.parse("p :- person_near(X, _). +!g : not wants_to_pass(_, _).")) == {
        "person_near",
        "wants_to_pass",
    }


PROGRAM = """
step(10).

+seen(N) : step(S) <- .abolish(step(_)); +step(S + N); !report(N).

@long[atomic]
+!report(N) <- say(N); .wait(2000); +told(N).
"""


def watched(source, **options):
    """Return an agent, its inspector, and the list into which the inspector writes."""
    thoughts = []
    inspector = MindInspector("me", thoughts.append)
    agent = bdi.Agent(
        bdi.parse(source), settings=bdi.AgentSettings(on_event=inspector.note), **options
    )
    return agent, inspector, thoughts


def test_the_changes_add_up_to_the_beliefs_of_the_agent():
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
    agent = bdi.Agent(program, settings=bdi.AgentSettings(on_event=inspector.note))
    agent.add_percept("seen(1)")
    agent.advance(1.0)
    inspector.look(1.0, agent)
    places = [step[2] for step in thoughts[0]["steps"] if step[0] == "plan"]
    assert places == ["mine.asl:4", "mine.asl:7"]


def test_a_step_without_changes_is_not_reported():
    agent, inspector, thoughts = watched(PROGRAM)
    for t in (1.0, 2.0, 3.0):
        agent.advance(t)
        inspector.look(t, agent)
    assert [thought["t"] for thought in thoughts] == [1.0]


def test_agents_are_inspected_only_on_request(tmp_path):
    trial = sim.Trial.load("scene_antagonistic")
    assert sim.run(trial).thoughts == ()
    run = record(trial, tmp_path / "run")
    lines = (tmp_path / "run" / "thoughts.jsonl").read_text(encoding="utf-8").splitlines()
    assert [json.loads(line) for line in lines] == list(run.thoughts)
    assert sim.load_run(tmp_path / "run").thoughts == run.thoughts
    arrivals = [event["t"] for event in events(run, "arrived")]
    arrived = [
        thought["t"]
        for thought in run.thoughts
        if any(step[1].startswith("+work_completed") for step in thought.get("steps", ()))
    ]
    assert [t for t in arrived if t in arrivals]
    assert set(arrived) <= set(arrivals)


def test_inspecting_agents_changes_no_result(tmp_path):
    trial = sim.Trial.load("scene_helpful")
    plain = sim.run(trial)
    recording = sim.Recording(tmp_path / "run")
    watched = sim.run(trial, recording)
    recording.close()
    assert watched.events == plain.events


LOOKS = """
+human_start <- !look; move(5, -10, 0).
+!look
  <- ?me(X, Y, V); .print("operator ", X, " ", Y, " ", V);
     ?gantry(GX, GY, GV); .print("gantry ", GX, " ", GY, " ", GV);
     for (agv(N, AX, AY, AV)) {{ .print(N, " ", AX, " ", AY, " ", AV) }};
     .wait({every}); !look.
+me(_, _, _) <- event.
+gantry(_, _, _) <- event.
+agv(_, _, _, _) <- event.
"""

TRIAL = """
floorplan: ariac2023
duration: 20.0
people: [{name: operator, personality: looks.asl, at: [-15, -10]}]
gantry:
  controller: oblivious
  jobs: [{move: [-7.0, 2.0, 0.0]}, {move: [-2.5, 0.5, 1.0]}]
agvs:
  agv1: [{time: 1.0, to: assembly_front}]
  agv4: [{time: 2.0, to: warehouse}]
"""


@given(st.integers(150, 2000))
@settings(max_examples=10)
def test_live_beliefs_are_those_of_the_time_of_the_query(tmp_path_factory, every):
    folder = tmp_path_factory.mktemp("looks")
    (folder / "looks.asl").write_text(LOOKS.format(every=every))
    run = sim.run(sim.Trial.parse(TRIAL, folder=folder))
    said = events(run, "said")
    assert len(said) == 6 * (20_000 // every + (20_000 % every > 0))
    moving = 0
    for event in said:
        name, *figures = event["text"].split()
        state = run.motions[name].state(event["t"])
        assert tuple(map(float, figures)) == pytest.approx((*state.at, state.speed), abs=1e-6)
        moving += state.speed > 0.1
    assert moving > 5


def test_an_agent_without_belief_queries_computes_no_live_beliefs(monkeypatch):
    queries = []
    live_beliefs = company.live_beliefs

    def counted(*bodies):
        return {
            key: lambda key=key, source=source: queries.append(key) or source()
            for key, source in live_beliefs(*bodies).items()
        }

    monkeypatch.setattr(company, "live_beliefs", counted)
    run = sim.run(sim.Trial.load("ariac2023"))
    assert run.summary["people"]["operator"]["visits"]
    assert run.thoughts == () and not queries
