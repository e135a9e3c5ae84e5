"""Minds: what a person is told, and people who are told from outside what to do."""

from run_events import events

import bdi
import sim
from sim.people.minds import Outside
from sim.people.perception import Percepts

OUTSIDE = """
floorplan: ariac2023
duration: 60.0
people: [{name: operator, personality: external, start: {time: 2.0}}]
gantry: {at: [-5.0, 2.0, 0.0]}
"""


def test_a_person_without_a_program_does_what_is_asked():
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


def test_the_safe_zone_is_not_optional_for_somebody_outside():
    simulation = sim.Simulation(sim.Trial.parse(OUTSIDE))
    (person,) = simulation.people
    simulation.advance(3.0)
    person.act(bdi.parse_literal("move(-5.0, 3.75, 0)"))
    simulation.advance(60.0)
    kinds = [event["kind"] for event in simulation.finish().events]
    assert kinds.count("violation") == kinds.count("teleport") == 1
    assert kinds.index("violation") < kinds.index("teleport")


def test_what_is_perceived_waits_outside_in_its_order():
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


def test_only_the_latest_percept_of_a_kind_is_kept():
    agent = bdi.Agent(bdi.parse(""))
    percepts = Percepts(agent)
    for _ in range(3):
        percepts.count("work_completed")
        agent.advance(agent.now + 1.0)
    percepts.see("at", 1.0, 2.0)
    agent.advance(agent.now + 1.0)
    assert {str(percept) for percept in agent.percepts} == {"work_completed(2)", "at(1,2)"}


def test_check_doubts_programs_of_people_that_do_not_do_what_they_say(tmp_path, floorwalker):
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
