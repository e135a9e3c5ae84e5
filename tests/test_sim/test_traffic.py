"""Traffic of machines: they wait, evade and give way, and never collide."""

import math
import random
import textwrap

import numpy as np
import pytest
import shapely
from run_events import events

import sim
from floorplan import InputError


def corridor(niche):
    """Return a corridor with a passing place at this x."""
    west, east = niche - 1, niche + 1
    place = f"[{east}, 1.6], [{east}, 4], [{west}, 4], [{west}, 1.6]"
    return f"""
name: corridor
boundary: [[0, 0], [20, 0], [20, 1.6], {place}, [0, 1.6]]
stations: {{west: [1.5, 0.8], east: [18.5, 0.8], niche: [{niche}, 3]}}
"""


CORRIDOR = corridor(10)

HALL = """
name: hall
boundary: [[0, 0], [20, 0], [20, 12], [0, 12]]
stations: {north: [10, 10.5], south: [10, 1.5], west: [2, 6], east: [18, 6]}
"""


def run(machines, *, floor=HALL, duration=120, more=""):
    """Return the run of machines on a floor, each with its keys as YAML."""
    listed = "".join(f"  {name}: {{{keys}}}\n" for name, keys in machines.items())
    shown = textwrap.indent(floor, "  ")
    text = f"floorplan:\n{shown}\nduration: {duration}\nrules: observe\n{more}machines:\n{listed}"
    return sim.run(sim.Trial.parse(text))


def amr(at, *missions, more=""):
    """Return the keys of a vehicle with missions to these places."""
    listed = ", ".join(f"{{go: {place}}}" for place in missions)
    return f"kind: amr, at: {at}, missions: [{listed}]{more}"


def require_arrivals(finished, **counts):
    """Check that no machines collide, none is stuck, and each completes its number of missions."""
    assert finished.summary["collisions"] == finished.summary["traffic_deadlocks"] == 0
    done = {name: finished.summary["machines"][name]["jobs_done"] for name in counts}
    assert done == counts, [
        e for e in finished.events if e["kind"].startswith(("machine", "traffic"))
    ]


def test_two_vehicles_head_on_in_a_corridor_use_the_passing_place():
    machines = {"a": amr("[1.5, 0.8, 0.0]", "east"), "b": amr("[18.5, 0.8, 3.1416]", "west")}
    finished = run(machines, floor=CORRIDOR)
    require_arrivals(finished, a=1, b=1)
    (evaded,) = [e for e in events(finished, "machine_evades") if "to" in e]
    assert evaded["machine"] == "b" and evaded["to"][1] > 1.6


def test_the_vehicle_of_lower_priority_evades():
    machines = {
        "a": amr("[1.5, 0.8, 0.0]", "east"),
        "b": amr("[18.5, 0.8, 3.1416]", "west", more=", priority: 1"),
    }
    finished = run(machines, floor=CORRIDOR)
    require_arrivals(finished, a=1, b=1)
    assert {e["machine"] for e in events(finished, "machine_evades")} == {"a"}


def test_the_vehicle_under_way_for_longer_keeps_its_path():
    later = amr("[1.5, 0.8, 0.0]", "east").replace("[{", "[{wait: 2}, {")
    finished = run({"a": later, "b": amr("[18.5, 0.8, 3.1416]", "west")}, floor=corridor(8))
    require_arrivals(finished, a=2, b=1)
    assert {e["machine"] for e in events(finished, "machine_evades")} == {"a"}


def test_a_vehicle_gives_up_its_right_of_way_if_no_other_can_evade():
    """The passing place is behind `a` when they meet."""
    machines = {"a": amr("[5, 0.8, 0.0]", "east"), "b": amr("[18.5, 0.8, 3.1416]", "west")}
    finished = run(machines, floor=corridor(5))
    require_arrivals(finished, a=1, b=1)
    (evaded,) = [e for e in events(finished, "machine_evades") if "to" in e]
    assert evaded["machine"] == "a" and evaded["to"][1] > 1.6


def test_a_corridor_without_a_passing_place_is_a_deadlock_of_both():
    plain = CORRIDOR.replace("[11, 1.6], [11, 4], [9, 4], [9, 1.6], ", "").replace(
        ", niche: [10, 3]", ""
    )
    machines = {"a": amr("[1.5, 0.8, 0.0]", "east"), "b": amr("[18.5, 0.8, 3.1416]", "west")}
    finished = run(machines, floor=plain, duration=60)
    assert finished.summary["collisions"] == 0 and finished.summary["traffic_deadlocks"] == 1
    (deadlock,) = events(finished, "traffic_deadlock")
    assert sorted(deadlock["machines"]) == ["a", "b"]
    waited = {name: finished.summary["machines"][name]["waiting_time"] for name in "ab"}
    assert min(waited.values()) > 30 and finished.summary["waiting_time"] == sum(waited.values())


def test_a_crossing_vehicle_waits_and_continues():
    machines = {
        "a": amr("[2.0, 6.0, 0.0]", "[18, 6]"),
        "b": amr("[10.0, 1.5, 1.5708]", "[10, 10.5]"),
    }
    finished = run(machines)
    require_arrivals(finished, a=1, b=1)
    (waits,) = events(finished, "machine_waiting")
    (proceeds,) = events(finished, "machine_proceeds")
    assert waits["machine"] == proceeds["machine"] and proceeds["waited"] > 0


def test_four_vehicles_share_a_station():
    places = ["[2, 2, 0.0]", "[18, 2, 3.0]", "[2, 10, 0.0]", "[18, 10, 3.0]"]
    home = ["[2, 2]", "[18, 2]", "[2, 10]", "[18, 10]"]
    machines = {
        f"v{k}": f"kind: amr, at: {at}, missions: [{{go: [10, 6]}}, {{wait: 10}}, {{go: {back}}}]"
        for k, (at, back) in enumerate(zip(places, home, strict=True))
    }
    finished = run(machines, duration=240)
    require_arrivals(finished, v0=3, v1=3, v2=3, v3=3)


def test_two_vehicles_swap_their_places():
    machines = {"a": amr("[2.0, 6.0, 0.0]", "east"), "b": amr("[18.0, 6.0, 0.0]", "west")}
    require_arrivals(run(machines), a=1, b=1)


def test_a_vehicle_without_missions_makes_way():
    machines = {"a": amr("[1.5, 0.8, 0.0]", "east"), "idle": "kind: amr, at: [8.0, 0.8, 0.0]"}
    finished = run(machines, floor=CORRIDOR)
    require_arrivals(finished, a=1)
    parked = {**machines, "idle": machines["idle"] + ", controller: parked"}
    finished = run(parked, floor=CORRIDOR)
    require_arrivals(finished, a=0)
    (blocked,) = events(finished, "machine_blocked")
    assert blocked["machine"] == "a"


def test_a_second_evasion_works_too():
    """The first evasion ends with a turn to the other side, so at another number of whole turns."""
    text = f"floorplan:\n{textwrap.indent(HALL, '  ')}\nduration: 60\nmachines:\n  a: {{" + amr(
        "[2, 6, 0.0]", "[18, 6, 3.1]"
    )
    simulation = sim.Simulation(sim.Trial.parse(text + "}\n"))
    simulation.start()
    simulation.advance(3.0)
    vehicle = simulation.machines["a"]
    vehicle.hold(True)
    simulation.advance(8.0)
    for north in (7.0, 8.5):
        assert vehicle.evade([shapely.box(9.0, 0.0, 11.0, north)], []) is not None
    vehicle.hold(False)
    simulation.advance(60.0)
    motion = simulation.finish().motions["a"]
    x, y = motion.position(np.linspace(0.0, 60.0, 601)).T
    assert y[(x > 9.0) & (x < 11.0)].min() > 8.5 + 0.4
    assert math.remainder(motion.rotation(60.0) - 3.1, math.tau) == pytest.approx(0.0)


TUG = "kind: agv, origin: [10, 1.5], heading: 1.5707963, limits: [0, 9], moves: {moves}"


def test_a_vehicle_waits_for_an_agv_whose_lane_crosses():
    tug = TUG.format(moves="[{time: 2, to: 9}, {time: 40, to: 0}]")
    machines = {"a": amr("[2, 6, 0.0]", "[18, 6]"), "tug": tug}
    finished = run(machines)
    require_arrivals(finished, a=1)
    assert len(events(finished, "agv_moved")) >= 2


def test_agvs_whose_lanes_cross_wait_for_each_other():
    tug = TUG.format(moves="[{time: 1, to: 9}]")
    other = tug.replace("[10, 1.5], heading: 1.5707963", "[5.5, 6], heading: 0.0")
    finished = run({"tug": tug, "other": other}, duration=60)
    assert finished.summary["collisions"] == 0
    (waits,) = events(finished, "machine_waiting")
    assert {waits["machine"], waits["for_machine"]} == {"tug", "other"}
    ends = [finished.motions[name].position(60.0).tolist() for name in ("tug", "other")]
    assert ends == [pytest.approx([10.0, 10.5]), pytest.approx([14.5, 6.0])]


def test_gantries_on_one_rail_wait_for_each_other():
    text = """
floorplan: ariac2023
duration: 60
people: [{name: ada, at: [-19, 0]}]
gantry: {controller: parked, at: [-6.0, 4.8, 0.0]}
machines:
  other:
    kind: gantry
    x: [-14.0, -1.0]
    at: [-12.0, 4.8, 0.4]
    controller: oblivious
    jobs: [{move: [-2.0, 4.0, 0.4]}]
"""
    finished = sim.run(sim.Trial.parse(text))
    assert finished.summary["collisions"] == 0
    (waits,) = events(finished, "machine_waiting")
    assert waits["machine"] == "other" and waits["for_machine"] == "gantry"


ON_ONE_RAIL = """
floorplan: ariac2023
duration: 120
rules: observe
gantry: {{controller: oblivious, at: [-6.0, 4.8, 0.0], jobs: {jobs}}}
machines:
  other:
    kind: gantry
    x: [-14.0, -1.0]
    at: [-12.0, 4.8, 0.0]
    controller: oblivious
    jobs: [{{move: [-2.0, 4.8, 0.0]}}]
"""


@pytest.mark.parametrize("jobs", ["[{move: [-12.0, 4.8, 0.0]}]", "[]"])
def test_a_gantry_gives_way_to_another(jobs):
    """Each wants the place of the other, or one has nothing to do."""
    finished = sim.run(sim.Trial.parse(ON_ONE_RAIL.format(jobs=jobs)))
    assert finished.summary["collisions"] == finished.summary["traffic_deadlocks"] == 0
    done = [e.get("machine", "gantry") for e in events(finished, "job_done")]
    assert sorted(done) == (["gantry", "other"] if jobs != "[]" else ["other"])


STEERING = """
def ahead(vehicle):
    return (1.0, 0.0)

def around(vehicle):
    return (0.6, 0.4)

def back_when_it_waits(vehicle):
    back.append(vehicle.now) if vehicle.waits else None
    return (-0.5, 0.0) if back and vehicle.now < back[0] + 2.0 else (0.5, 0.0)

back = []
"""


def steered(folder, a, b, duration):
    """Return the run of two vehicles on one line with these keys, and functions of twists."""
    (folder / "steering.py").write_text(STEERING)
    text = f"""
floorplan:
{textwrap.indent(HALL, "  ")}
duration: {duration}
rules: observe
machines:
  a: {{kind: amr, {a}}}
  b: {{kind: amr, {b}}}
"""
    return sim.run(sim.Trial.parse(text, folder=folder))


def test_functions_of_twists_cannot_drive_into_others(tmp_path):
    a = 'at: [2, 6, 0.0], controller: "steering:ahead", rate: 10'
    b = 'at: [11, 6, 3.1416], controller: "steering:around", rate: 10'
    finished = steered(tmp_path, a, b, 40)
    assert finished.summary["collisions"] == 0
    assert events(finished, "machine_waiting")


def test_a_function_can_drive_away_while_its_vehicle_waits(tmp_path):
    a = 'at: [4, 6, 0.0], controller: "steering:back_when_it_waits", rate: 10'
    finished = steered(tmp_path, a, "at: [8, 6, 3.1416], controller: parked", 20)
    assert finished.summary["collisions"] == 0
    waits, *_ = events(finished, "machine_waiting")
    proceeds, *_ = events(finished, "machine_proceeds")
    assert waits["t"] < proceeds["t"] < waits["t"] + 2.0
    west = finished.motions["a"].position(waits["t"] + 2.0)[0]
    assert west < finished.motions["a"].position(waits["t"])[0]


def test_bad_keys_are_named():
    def problem(keys):
        with pytest.raises(InputError) as why:
            run({"a": keys, "b": amr("[5, 6, 0.0]")})
        return [(one.field, one.message) for one in why.value.problems]

    assert [field for field, _ in problem(amr("[2, 6, 0.0]", more=", priority: high"))] == [
        "machines.a.priority"
    ]
    assert problem(amr("[5.2, 6, 0.0]")) == [("machines.b", "starts where a stands")]


def random_trial(seed, duration):
    """Return a trial of two to six vehicles in the warehouse with random missions."""
    draw = random.Random(seed)
    places = [[3, 6], [3, 16.5], [8.5, 10], [12.5, 13], [16.5, 6], [20.5, 9], [24.5, 13], [28, 10]]
    starts = draw.sample(places, draw.randint(2, 6))
    machines = {}
    for k, (x, y) in enumerate(starts):
        missions = [
            f"{{go: [{east}, {north}]}}, {{wait: {draw.randint(1, 20)}}}"
            for east, north in draw.sample(places, draw.randint(2, 4))
        ]
        turn = draw.choice((1.5708, -1.5708))
        size = draw.choice(("[1.2, 0.8]", "[0.7, 0.5]", "[1.6, 0.8]"))
        kind = draw.choice(("differential", "holonomic"))
        machines[f"v{k}"] = (
            f"kind: amr, at: [{x}, {y}, {turn}], size: {size}, drive: {kind}, repeat: true,"
            f" missions: [{', '.join(missions)}]"
        )
    listed = "".join(f"  {name}: {{{keys}}}\n" for name, keys in machines.items())
    moves = "[{time: 5, to: east, every: 120}, {time: 65, to: west, every: 120}]"
    agvs = f"agvs: {{tug1: {moves}}}\n" if draw.random() < 0.3 else ""
    text = f"floorplan: warehouse\nduration: {duration}\nrules: observe\n{agvs}machines:\n{listed}"
    return sim.Trial.parse(text)


def check_random(seed, duration):
    finished = sim.run(random_trial(seed, duration))
    assert finished.summary["collisions"] == finished.summary["traffic_deadlocks"] == 0
    for name, figures in finished.summary["machines"].items():
        if name.startswith("v"):
            late = [
                e["t"] for e in events(finished, "job_done", machine=name) if e["t"] > duration / 2
            ]
            assert late, (seed, name, figures)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_random_vehicles_neither_collide_nor_get_stuck(seed):
    check_random(seed, duration=240)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 3, 4, 5, 10, 37, 38, 48])
def test_many_random_vehicles_neither_collide_nor_get_stuck(seed):
    check_random(seed, duration=600)


SIDE_BY_SIDE = "[4, {y}, 0]"
END_TO_END = "[{x}, 4, 0]"
ACROSS = "[{x_across}, 4, 1.5707963]"
CORNER_TO_CORNER = "[{x}, {y}, 0]"


@pytest.mark.parametrize("gap", [0.0, 0.001, 0.005, 0.009, 0.010])
@pytest.mark.parametrize("place", [END_TO_END, SIDE_BY_SIDE, ACROSS, CORNER_TO_CORNER])
def test_vehicles_that_start_almost_in_contact_part(place, gap):
    if gap == 0.0 and place in (SIDE_BY_SIDE, ACROSS):
        gap = 1e-4  # at 0 both would stand in one place except for rounding
    at = place.format(x=5.2 + gap, y=4.8 + gap, x_across=5.0 + gap)
    text = f"""
    floorplan: {{boundary: [[0, 0], [14, 0], [14, 8], [0, 8]], stations: {{a: [2, 4], b: [12, 4]}}}}
    duration: 60
    machines:
      v1: {{kind: amr, at: [4, 4, 0], missions: [{{go: b}}]}}
      v2: {{kind: amr, at: {at}, missions: [{{go: a}}]}}
    """
    run = sim.run(sim.Trial.parse(textwrap.dedent(text)))
    assert run.summary["traffic_deadlocks"] == run.summary["collisions"] == 0
    assert [one["jobs_done"] for one in run.summary["machines"].values()] == [1, 1]
