"""People whose goal is occupied by an AGV."""

import math

import pytest
import yaml
from run_events import events, said

import navigation
import sim

FLOOR = """
boundary: [[0, 0], [30, 0], [30, 16], [0, 16]]
stations: {dock: [16, 5], desk: [28, 14]}
patrol: [dock, desk]
safe_zone: {at: [28, 10]}
agvs:
  size: [1.2, 0.8]
  height: 1.0
  max_speed: 2.0
  max_acceleration: 2.0
  limits: [0.0, 13.0]
  locations: {near: 0.0, far: 13.0}
  start: near
  lanes: {cart: {origin: [3.0, 5.0], heading: 0.0}}
"""

VISIT = """
+human_start <- .wait(8000); move(16, 5, 0).
+work_completed(N) <- .print(completed, N).
+goal_occupied(N) <- .print(occupied, N).
"""


@pytest.fixture
def run(tmp_path):
    def go(moves, program=VISIT, personality="mine.asl", yields=False, duration=60):
        (tmp_path / "floor.yaml").write_text(FLOOR)
        (tmp_path / "mine.asl").write_text(program)
        text = (
            f"floorplan: floor.yaml\nduration: {duration}\n"
            f"people: [{{name: a, personality: {personality}}}]\n"
            f"agvs: {{cart: {{yield: {str(yields).lower()}, moves: {moves}}}}}\n"
        )
        return sim.run(sim.Trial.parse(text, folder=tmp_path))

    return go


def kinds(run):
    selected = ("goal", "goal_occupied", "goal_free", "path_blocked", "arrived", "violation")
    return [event["kind"] for event in events(run, *selected)]


@pytest.mark.parametrize("yields", [False, True])
def test_a_person_waits_beside_the_goal_until_the_agv_has_left(run, yields):
    moves = "[{time: 0, to: far}, {time: 30, to: near}]"
    result = run(moves, yields=yields)
    assert kinds(result) == ["goal", "goal_occupied", "goal_free", "arrived"]
    occupied, free = events(result, "goal_occupied", "goal_free")
    assert occupied["by"] == "cart"
    assert (occupied["goal"], free["goal"]) == ([16, 5], [16, 5])
    waited = result.motions["a"].state(29.0)
    assert waited.speed == 0.0
    # The person waits far enough away for the AGV to start. At its 2 m/s the rules require 3 m, or
    # 5.5 m for a walking person. A yielding AGV looks 2 s ahead.
    away = 3.1 if not yields else 7.6
    assert math.dist(waited.at, (16, 5)) == pytest.approx(away, abs=0.01)
    assert 30.0 < free["t"] < events(result, "agv_moved")[-1]["arrives"]
    # The goal is free once a person beside it would be far enough from the AGV.
    cart = result.motions["cart"]
    left = math.dist(cart.position(free["t"]), cart.position(29.0))
    assert left >= away
    assert result.motions["a"].position(60.0) == pytest.approx((16, 5))
    assert said(result) == ["occupied0", "completed0"]


def test_a_walking_person_waits_when_an_agv_stops_on_their_goal(run):
    program = VISIT.replace(".wait(8000)", ".wait(100)")
    result = run("[{time: 0, to: far}, {time: 25, to: near}]", program)
    assert kinds(result) == [
        "goal",
        "path_blocked",
        "goal_occupied",
        "goal_free",
        "arrived",
    ]
    stopped = events(result, "agv_moved")[0]["arrives"]
    assert events(result, "goal_occupied")[0]["t"] == pytest.approx(stopped)


def test_the_agent_may_choose_another_goal(run):
    program = VISIT.replace(".print(occupied, N)", "move(28, 14, 0)")
    result = run("[{time: 0, to: far}, {time: 25, to: near}]", program)
    assert kinds(result) == ["goal", "goal_occupied", "goal", "arrived"]
    assert result.motions["a"].position(60.0) == pytest.approx((28, 14))


def test_people_on_patrol_wait_for_a_while_and_go_to_the_next_station(run):
    result = run("[{time: 0, to: far}]", personality="indifferent", duration=120)
    stations = [event["station"] for event in events(result, "arrived")]
    assert set(stations) == {"desk"}
    occupied = [event["t"] for event in events(result, "goal_occupied")]
    assert len(occupied) >= 2
    desk = [event["t"] for event in events(result, "goal") if event["station"] == "desk"]
    beside = next(t for t in desk if t > occupied[0])
    standing = result.motions["a"].velocity([beside - 7.5, beside - 4.0, beside - 0.1])
    assert abs(standing).max() == 0.0
    assert result.motions["a"].state(beside - 8.6).speed > 0


def test_people_on_patrol_with_a_short_wait_stay_on_their_route(run):
    moves = "[{time: 0, to: far}, {time: 18, to: near}]"
    result = run(moves, personality="indifferent", duration=60)
    goals = [event["station"] for event in events(result, "goal")]
    assert goals[:3] == ["dock", "desk", "dock"]
    arrived = [event["station"] for event in events(result, "arrived")]
    assert arrived[:2] == ["dock", "desk"]


def test_an_agv_that_drives_across_is_let_pass(run, tmp_path):
    """Under lenient rules, under which only contact counts, the person waits and then continues."""
    (tmp_path / "close.yaml").write_text("agv_law: {fixed: 0.2}\n")
    program = "+human_start <- move(11, 1, 0); .wait(100); move(11, 12, 0)."
    (tmp_path / "floor.yaml").write_text(FLOOR)
    (tmp_path / "mine.asl").write_text(program)
    text = (
        "floorplan: floor.yaml\nduration: 30\nrules: close.yaml\n"
        "people: [{name: a, personality: mine.asl, at: [11, 1.5]}]\n"
        "agvs: {cart: [{time: 0.05, to: far}]}\n"
    )
    result = sim.run(sim.Trial.parse(text, folder=tmp_path))
    (arrived,) = events(result, "arrived")
    assert arrived["at"] == [11, 12] and arrived["t"] < 18.0
    lane = result.trial.floorplan.lane("cart")
    shapes = navigation.Shapes(machine=(navigation.Box.of_agv(lane),))
    pair = (result.motions["a"], result.motions["cart"])
    assert navigation.minimum_separation(*pair, 0.0, 30.0, shapes=shapes)[1] >= 0.1


def test_a_query_for_a_waiting_place_changes_no_position(run):
    result = run("[]", program="+human_start <- move(3, 5, 0).")
    assert "goal_occupied" in kinds(result)
    simulation = sim.Simulation(result.trial)
    before = simulation.world.changes
    simulation.advance(60)
    assert simulation.world.changes == before


def test_a_person_continues_after_a_vehicle_has_left_the_goal(tmp_path):
    floor = {"boundary": [[0, 0], [30, 0], [30, 10], [0, 10]]}
    floor |= {"stations": {"dock": [6, 5]}, "safe_zone": {"at": [28, 9]}}
    drive = [{"wait": 3}, {"go": [28, 5]}]
    cart = {"kind": "amr", "at": [6, 5, 0], "max_speed": 0.8, "missions": drive}
    (tmp_path / "go.asl").write_text("+human_start <- move(6, 5, 0).\n")
    keys = {"floorplan": floor, "duration": 40, "rules": "observe", "machines": {"cart": cart}}
    keys["people"] = [{"name": "a", "at": [3, 5], "personality": "go.asl"}]
    result = sim.run(sim.Trial.parse(yaml.safe_dump(keys), folder=tmp_path))
    waited = events(result, "goal", "goal_occupied", "goal_free", "arrived")
    assert [event["kind"] for event in waited] == ["goal", "goal_occupied", "goal_free", "arrived"]
    free = waited[2]
    assert math.dist(result.motions["cart"].state(free["t"]).at, (6, 5)) < 3.0
