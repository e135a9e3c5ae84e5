"""People: their starts, the actions of their programs, and obstacles in their way."""

import math

import numpy as np
import pytest
import shapely
from run_events import events, said
from shapely.geometry import box

import bdi
import floorplan
import sim

ALONE = "floorplan: ariac2023\nduration: {duration}\ngantry: {{at: [0.4, 7.0, 0.0]}}\n"


def run(text, folder=".", duration=60):
    trial = sim.Trial.parse(ALONE.format(duration=duration) + text, folder=folder)
    return sim.run(trial)


@pytest.fixture
def program(tmp_path):
    """Return a function that runs one person with a program, and more lines of a trial."""

    def go(text, more="", duration=60, at="[-15, -10]"):
        (tmp_path / "mine.asl").write_text(text)
        person = f"people: [{{name: a, personality: mine.asl, at: {at}}}]\n"
        return run(person + more, tmp_path, duration)

    return go


def test_a_person_starts_at_a_time():
    finished = run("people: [{name: a, start: {time: 12.5}}]")
    assert [event["t"] for event in events(finished, "human_started")] == [12.5]
    assert finished.motions["a"].state(12.4).speed == 0
    assert finished.motions["a"].state(14.0).speed > 0
    assert finished.summary["people"]["a"]["started"] == 12.5


JOBS = """
people: [{{name: a, start: {start}}}]
gantry:
  controller: oblivious
  at: [-2.0, 4.0, 0.0]
  jobs:
    - {{pick: bin1, place: agv1, part: red pump}}
    - {{wait: 2.0}}
    - {{submit: A1}}
    - {{wait: 30.0}}
    - {{pick: bin1, place: agv1, part: blue pump}}
    - {{submit: A2}}
"""


@pytest.mark.parametrize(
    ("start", "kind"),
    [
        ("{part_placed: {part: red pump, agv: agv1}}", "job_done"),
        ("{part_placed: {agv: agv1}}", "job_done"),
        ("{part_placed: {part: blue pump}}", None),
        ("{order_submitted: A1}", "order_submitted"),
        ("{order_submitted: A2}", None),
    ],
)
def test_a_person_starts_at_an_event(start, kind):
    text = "floorplan: ariac2023\nduration: 30\n" + JOBS.format(start=start)
    finished = sim.run(sim.Trial.parse(text))
    started = [event["t"] for event in events(finished, "human_started")]
    assert started == ([events(finished, kind)[0]["t"]] if kind else [])


@pytest.mark.parametrize(
    ("patrol", "visits"), [(None, ["gate", "press"]), (("press",), ["press", "press"]), ((), [])]
)
def test_people_on_a_floor_made_in_python_go_to_all_stations_by_default(patrol, visits):
    floor = floorplan.Floorplan(
        name="yard",
        boundary=box(0.0, 0.0, 12.0, 12.0),
        stations=(
            floorplan.Station("gate", (9.0, 2.0)),
            floorplan.Station("press", (9.0, 9.0)),
        ),
        patrol=patrol,
        safe_zone=floorplan.SafeZone((2.0, 2.0)),
    )
    finished = sim.run(sim.Trial(floor, duration=20.0, people=(sim.PersonEntry("ada"),)))
    assert finished.summary["people"]["ada"]["visits"][:2] == visits


def test_several_people_walk_at_once_each_with_their_own_agent():
    finished = run(
        "people: [{name: a, personality: helpful}, {name: b, start: {time: 3}},"
        " {name: c, max_speed: 0.5, at: [-5, 0]}]"
    )
    assert {event["person"] for event in events(finished, "arrived")} == {"a", "b", "c"}
    speeds = {name: finished.sample(100)[name][:, 3:] for name in "abc"}
    tops = {name: np.hypot(*velocity.T).max() for name, velocity in speeds.items()}
    assert tops == pytest.approx({"a": 1.0, "b": 1.0, "c": 0.5})
    assert finished.summary["people"]["a"]["visits"][:2] == ["station4", "station2"]


def test_the_same_person_behaves_the_same_with_others_out_of_the_way():
    alone = run("people: [{name: a}]")
    beside = run("people: [{name: b, start: {time: 1000}, at: [-1, -9]}, {name: a}]")
    ts = np.linspace(0, 60, 600)
    apart = alone.motions["a"].position(ts) - beside.motions["a"].position(ts)
    assert np.abs(apart).max() < 1e-3


def test_an_agv_that_parks_in_the_way_makes_a_walker_replan(program):
    """The walk along y = 4.8 is free when it begins. Then agv1 parks on it, far ahead."""
    finished = program(
        "!go. +!go <- walk_speed(0.3); move(-4, 4.8, 0).",
        "agvs: {agv1: [{time: 1.0, to: assembly_front}]}",
        at="[-14.5, 4.8]",
    )
    (blocked,) = events(finished, "path_blocked")
    (replanned,) = events(finished, "replanned")
    stopped = events(finished, "agv_moved")[0]["arrives"]
    assert blocked["t"] == replanned["t"] == pytest.approx(stopped)
    assert finished.summary["people"]["a"]["replans"] == 1
    assert events(finished, "arrived")[0]["at"] == [-4.0, 4.8]
    ts = np.linspace(stopped, 60, 5000)
    agv = finished.trial.floorplan.lane("agv1").footprint(5.6)
    points = shapely.points(finished.motions["a"].position(ts))
    assert shapely.distance(points, agv).min() >= 0.3 - 1e-9


def test_a_path_that_was_free_before_is_not_reused_once_it_is_blocked(program):
    """The person walks along y = 4.8 and back. Then agv1 has parked there, so the third walk
    detours.
    """
    finished = program(
        "!go. +!go <- move(-4, 4.8, 0); .wait(12000); move(-14.5, 4.8, 0);"
        " .wait(18000); move(-4, 4.8, 0).",
        "agvs: {agv1: [{time: 25.0, to: assembly_front}]}",
        at="[-14.5, 4.8]",
        duration=120,
    )
    first, _, second = [event["t"] for event in events(finished, "arrived")]
    motion, agv = finished.motions["a"], finished.trial.floorplan.lane("agv1").footprint(5.6)
    ways = [motion.position(np.linspace(t - 20, t, 2000)) for t in (first, second)]
    gaps = [shapely.distance(shapely.points(way), agv).min() for way in ways]
    assert gaps[0] == 0.0
    assert gaps[1] >= 0.3 - 1e-9
    assert not events(finished, "path_blocked")


def test_a_goal_in_a_table_is_reported_and_the_action_fails(program):
    finished = program(
        """
        !go.
        +!go <- move(-7.7, 3.0, 0); .print("not reached").
        -!go <- .print("no way").
        +goal_blocked(N) <- .print("told ", N).
        """
    )
    assert sorted(said(finished)) == ["no way", "told 0"]
    (blocked,) = events(finished, "path_blocked")
    assert "assembly_table1" in blocked["message"]
    assert finished.summary["people"]["a"]["distance_walked"] == 0


def test_stopping_turning_and_walking_slowly(program):
    finished = program(
        """
        !go.
        +!go <- walk_speed(0.5); move(-10.8, -3.75, 0); .wait(4000); stop_movement;
                .wait(2000); face_gantry; .wait(1000); move_away(2).
        """
    )
    motion = finished.motions["a"]
    assert motion.state(3.0).speed == pytest.approx(0.5)
    assert motion.state(4.0 + 0.5 / 2.5 + 1e-3).speed == 0
    x, y = motion.state(6.5).at
    looking = math.atan2(7.0 - y, 0.4 - x)
    assert motion.rotation(6.5) == pytest.approx(looking)
    gap = math.dist(motion.state(60).at, motion.state(6.5).at)
    assert gap == pytest.approx(2.0, abs=1e-6)
    assert math.dist(motion.state(60).at, (0.4, 7.0)) > math.dist((x, y), (0.4, 7.0))


def test_random_draws_depend_on_the_seed_and_the_person(tmp_path):
    (tmp_path / "dice.asl").write_text("!go. +!go <- .random(R); .print(R).")
    people = "people: [{name: a, personality: dice.asl}, {name: b, personality: dice.asl}]"
    thrown = [
        [event["text"] for event in events(run(f"seed: {seed}\n{people}", tmp_path), "said")]
        for seed in (0, 0, 1)
    ]
    assert thrown[0] == thrown[1]
    assert len({*thrown[0], *thrown[2]}) == 4


def test_a_person_at_the_goal_arrives_after_a_moment(program):
    finished = program("!go. +!go <- move(-15, -10, 0). +work_completed(N) <- .print(N).")
    assert [event["t"] for event in events(finished, "said")] == [pytest.approx(0.1)]


def test_turning_at_speed_never_breaks_the_limits(program):
    """On a new goal behind, a walking person brakes first, then walks back."""
    finished = program("!go. +!go <- move(-10.8, -3.75, 0); .wait(3000); move(-15, -10, 0).")
    ts = np.linspace(0, 20, 20_001)
    velocity = finished.motions["a"].velocity(ts)
    change = np.hypot(*np.diff(velocity, axis=0).T) / np.diff(ts)
    assert change.max() <= 2.5 * (1 + 1e-3)
    assert finished.motions["a"].position(30.0) == pytest.approx((-15, -10))


def test_people_talk_to_each_other_at_one_time(tmp_path):
    (tmp_path / "asks.asl").write_text(
        "!go. +!go <- .wait(2500); .send(b, askOne, mood(_), mood(M)); .print(M);"
        " .send(b, achieve, cheer_up)."
    )
    (tmp_path / "told.asl").write_text(
        'mood(grumpy). +!cheer_up[source(S)] <- -+mood(glad); .print(glad, " of ", S).'
    )
    finished = run(
        "people: [{name: a, personality: asks.asl}, {name: b, personality: told.asl}]", tmp_path
    )
    said = [(event["t"], event["person"], event["text"]) for event in events(finished, "said")]
    assert said == [(2.5, "a", "grumpy"), (2.5, "b", "glad of a")]


def test_stepping_back_without_room_fails_and_is_reported(program):
    """The program learns that it failed, so that a scared person can leave the corner."""
    finished = program(
        "!go. +!go <- move_away(2). -!go <- .print(cornered). +path_blocked(_) <- .print(told).",
        at="[1.69, -11.69]",
    )
    assert sorted(said(finished)) == ["cornered", "told"]
    assert finished.summary["people"]["a"]["distance_walked"] == 0


@pytest.mark.parametrize("name", bdi.programs())
def test_every_personality_completes_a_trial_with_a_busy_gantry(name):
    finished = sim.run(
        sim.Trial.parse(
            f"""
floorplan: ariac2023
people: [{{name: a, personality: {name}}}]
gantry:
  controller: oblivious
  repeat: true
  jobs: [{{pick: bin1, place: agv2}}, {{move: [-9.0, 2.0, 0.0]}}, {{pick: bin8, place: agv4}}]
agvs: {{agv2: [{{time: 60.0, to: as1}}, {{time: 120.0, to: kitting}}]}}
"""
        )
    )
    assert finished.duration == 275.0
    assert finished.summary["people"]["a"]["distance_walked"] > 20
    assert events(finished, "warning") == []
    assert events(finished, "gantry_detected")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("!go. +!go <- jump(3).", r"mine.asl:1:\d+: .*there is no action 'jump'"),
        ("!go.\n+!go <- X = 1;\n move(X).", r"mine.asl:3:\d+: .*should be move\(x, y, z\)"),
        ("!go. +!go <- move(here, there).", r"mine.asl:1:\d+: .*should be move\(x, y, z\)"),
        ("!go(a). +!go(X) <- !go(f(X)).", "mine.asl"),
    ],
)
def test_programs_with_impossible_actions_are_rejected(program, text, message):
    with pytest.raises((floorplan.UserError, bdi.ProgramError), match=message):
        program(text)


def test_a_program_that_acts_endlessly_at_one_time_is_stopped(program):
    """The blocked path is reported at once, and the program requests the same path at once."""
    with pytest.raises(
        (floorplan.UserError, bdi.ProgramError), match="repeats actions without end"
    ):
        program("!go. +!go <- move(-7.7, 3, 0). +goal_blocked(_) <- move(-7.7, 3, 0).")


def test_the_rules_of_the_competition():
    trial = sim.Trial.load("scene_indifferent")
    import dataclasses

    finished = sim.run(dataclasses.replace(trial, rules=sim.RULE_SETS["ariac2023"]))
    noticed = events(finished, "gantry_detected")
    assert noticed[0]["noticing_distance"] == 6.475
    gaps = np.diff([event["t"] for event in noticed])
    assert gaps.min() >= 20.0 - 1e-9
    violation = events(finished, "violation")[0]
    assert events(finished, "gantry_enabled")[0]["t"] == pytest.approx(violation["t"] + 15.0)
    after = [event for event in events(finished, "goal") if event["t"] > violation["t"] + 1e-6]
    assert after[0]["t"] == pytest.approx(violation["t"] + 10.0)


def test_a_simulation_continues_to_later_times():
    trial = sim.Trial.parse(ALONE.format(duration=20) + "people: [{name: ada}]\n")
    simulation = sim.Simulation(trial)
    for until in (0.0, 5.0, 5.0, 12.5, math.inf, 30.0):
        simulation.advance(until)
    assert simulation.over
    assert simulation.finish().events == sim.run(trial).events
    with pytest.raises(ValueError, match="seconds"):
        simulation.advance(math.nan)


@pytest.mark.parametrize("other", ["", "- {name: q, at: [1, 9], personality: external}\n"])
@pytest.mark.parametrize("later", [0.0, 0.04])
def test_two_turns_in_one_place_are_one_turn(other, later):
    """Each turn of 80° is possible at 0.5 m/s, both in one place are not, so the person stops."""
    floor = "floorplan: {boundary: [[0, 0], [10, 0], [10, 10], [0, 10]], stations: {a: [1, 1]}}\n"
    people = "people:\n- {name: p, at: [2, 5], max_speed: 0.5, personality: external}\n"
    simulation = sim.Simulation(sim.Trial.parse(floor + "duration: 60\n" + people + other))
    person = simulation.person("p")
    simulation.advance(1.0)
    assert person.send((8.0, 5.0))
    simulation.advance(5.0)
    x, y = person.body.at
    for turn in (80, 160):
        assert person.body.state.speed == pytest.approx(0.5)
        angle = math.radians(turn)
        assert person.send((x + 3 * math.cos(angle), y + 3 * math.sin(angle)))
        simulation.advance(simulation.clock.now + later)
    simulation.advance(40.0)
    track = person.body.track()
    assert track.position(40.0) == pytest.approx((x + 3 * math.cos(angle), y + 3 * math.sin(angle)))
    assert any(track.state(piece.end).speed < 1e-6 for piece in track.pieces if 5 < piece.end < 6)
