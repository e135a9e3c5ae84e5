"""One-way gates: people and AGVs obey them in every situation."""

import numpy as np
import pytest
from run_events import events, record
from small_floors import LANE, run_on

import floorplan
import sim

AISLES = """\
name: aisles
boundary: [[0, 0], [20, 0], [20, 10], [0, 10]]
obstacles:
  south: {x: [4, 16], y: [0, 3], z: [0, 3]}
  rack: {x: [4, 16], y: [4.5, 6], z: [0, 2]}
  north: {x: [4, 16], y: [7.5, 10], z: [0, 3]}
gates:
  in: {between: [[4, 3], [4, 4.5]], towards: [5, 4]}
  out: {between: [[16, 3], [16, 4.5]], towards: [17, 4]}
  back: {between: [[10, 6], [10, 7.5]], towards: [9, 7]}
stations: {west: [2, 3.75], east: [18, 3.75]}
safe_zone: {at: [10, 3.75]}
"""

PEOPLE = {
    "eve": "people: [{name: eve, personality: go.asl}]\n",
    "six": "people: [{name: eve, count: 6, personality: go.asl}]\n",
}
BACK = "+human_start <- move(2, 3.75, 0).\n"
TO_AND_FRO = """\
+human_start <- move(18, 3.75, 0).
+work_completed(N) : N mod 2 == 0 <- move(2, 3.75, 0).
+work_completed(N) <- teleport_safe; move(18, 3.75, 0).
"""


@pytest.fixture
def run(tmp_path):
    def run(text, program, floor=AISLES):
        (tmp_path / "go.asl").write_text(program)
        return run_on(floor, text, tmp_path)

    return run


def crossings(run, name, step=0.01):
    """Return the gates that the centre of a body passes: name, and whether in their direction.

    Teleports are not counted.
    """
    passages = []
    motion = run.motions[name]
    times = np.arange(0.0, run.duration, step)
    at = motion.position(times)
    walked = np.hypot(*np.diff(at, axis=0).T) < 0.5
    for gate in run.floorplan.gates:
        (ax, ay), (bx, by) = gate.ends
        along = (
            (at - gate.ends[0])
            @ np.subtract((bx, by), (ax, ay))
            / ((bx - ax) ** 2 + (by - ay) ** 2)
        )
        beyond = (at - gate.ends[0]) @ np.array(gate.normal) >= -1e-9
        through = (beyond[1:] != beyond[:-1]) & walked & (along[1:] >= 0) & (along[1:] <= 1)
        passages += [(times[k], gate.name, bool(beyond[k + 1])) for k in np.flatnonzero(through)]
    return [one[1:] for one in sorted(passages)]


@pytest.mark.parametrize("people", PEOPLE)
def test_a_person_leaves_a_one_way_aisle_in_its_direction(run, people):
    """People start there, six of them side by side, step aside and are moved back there."""
    result = run(f"duration: 110\n{PEOPLE[people]}", TO_AND_FRO)
    names = [person.name for person in result.scene.people]
    passed = [crossings(result, name) for name in names]
    assert all(ahead for one in passed for _, ahead in one)
    assert {name for one in passed for name, _ in one} == {"out", "back"}
    assert not events(result, "path_blocked") and not result.summary.get("overlaps")
    assert all(result.summary["people"][name]["visits"].count("west") >= 1 for name in names)


NICHE = (
    AISLES.replace("south: {x: [4, 16], y: [0, 3]", "south: {x: [4, 9], y: [0, 3]")
    .replace("  rack:", "  south2: {x: [11, 16], y: [0, 3], z: [0, 3]}\n  rack:")
    .replace("gates:\n", "gates:\n  niche: {between: [[9, 3], [11, 3]], towards: [10, 2]}\n")
)


def test_a_person_steps_aside_only_to_a_place_with_a_path_back(run):
    """No path leads out of the niche, so the person steps ahead, out of the aisle."""
    people = """\
people:
  - {name: eve, personality: external, at: [10, 3.75], radius: 0.45}
  - {name: max, personality: go.asl, at: [2, 3.75]}
"""
    result = run(f"duration: 60\n{people}", "+human_start <- move(18, 3.75, 0).", NICHE)
    assert {e["person"] for e in events(result, "gave_way")} == {"eve"}
    assert crossings(result, "eve") == [("out", True)]
    assert [e["person"] for e in events(result, "arrived")] == ["max"]


def test_a_path_only_against_the_direction_is_reported_as_blocked(run):
    only = AISLES.replace("towards: [9, 7]", "towards: [11, 7]")
    result = run(f"duration: 30\n{PEOPLE['eve']}", BACK, only)
    (blocked,) = events(result, "path_blocked")
    assert "but through in or back, against the direction" in blocked["message"]


def test_agvs_wait_before_a_gate_against_their_direction(run):
    floor = AISLES.replace("at: [10, 3.75]", "at: [2, 8]") + LANE.replace("2.75", "3.75")
    text = "duration: 60\nagvs: {cart: [{time: 0, to: 14}, {time: 30, to: %s}]}\n"
    back = run(text % "middle", BACK, floor)
    assert back.motions["cart"].position(60.0)[0] == pytest.approx(10.0)
    with pytest.raises(sim.TrialError, match=r"line .*agvs.cart\[1\].to: .*gate 'in' against"):
        run(text % "west", BACK, floor)
    other = floor.replace("towards: [5, 4]}", "towards: [5, 4], concerns: [max]}")
    assert run(text % "west", BACK, other).motions["cart"].position(60.0)[0] == pytest.approx(2.0)
    gates = floor[floor.index("gates:") : floor.index("stations:")]
    aisle = "zones: {aisle: {x: [4, 16], y: [3, 4.5], one_way: [1, 0]}}\n"
    with pytest.raises(
        sim.TrialError, match=r"agvs.cart\[1\].to: .*gate 'aisle \(entry\)' against"
    ):
        run(text % "west", BACK, floor.replace(gates, aisle))


def test_a_trial_adds_gates_to_a_floor_and_its_recording_has_them(tmp_path):
    text = "floorplan: {base: warehouse, gates: {lock: {between: %s, towards: %s}}}\nduration: 1\n"
    plan = floorplan.load("warehouse")
    west, south, _, north = plan.boundary.bounds
    x = west + 1.0
    trial = sim.Trial.parse(text % ([[x, south], [x, north]], [x + 1.0, 1.0]), folder=tmp_path)
    record(trial, tmp_path / "run")
    assert sim.load_run(tmp_path / "run").scene.floorplan.gates == trial.floorplan.gates


def test_gates_are_written_scaled_and_turned(tmp_path, floorwalker):
    plan = floorplan.parse(AISLES)
    plan.save(tmp_path / "floor.yaml")
    assert floorplan.load(tmp_path / "floor.yaml") == plan
    (tmp_path / "turned.yaml").write_text(
        "base: floor.yaml\norigin: [10, 0]\nrotation: 1.5707963267948966\n"
    )
    turned = floorplan.load(tmp_path / "turned.yaml").gates["in"]
    assert np.allclose(turned.ends, [(-3, -6), (-4.5, -6)]) and np.allclose(turned.normal, (0, 1))
    (tmp_path / "over.yaml").write_text(
        "base: floor.yaml\ngates: {back: {between: [[10, 7.5], [10, 6]], towards: [11, 7]}}\n"
    )
    assert floorplan.load(tmp_path / "over.yaml").gates["back"].normal == (1.0, 0.0)
    done = floorwalker("convert", "floor.yaml", "floor.geojson", cwd=tmp_path)
    assert "one-way gates" in done.stderr
