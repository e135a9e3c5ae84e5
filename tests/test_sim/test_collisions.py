"""Collisions of machines and contacts with people, which do not stop the machines."""

from dataclasses import replace

import pytest
from run_events import events
from small_floors import on_floor

import navigation
import sim

FLOOR = """\
boundary: [[0, 0], [20, 0], [20, 20], [0, 20]]
stations: {a: [1, 1], b: [19, 1]}
agvs:
  size: [1.2, 0.8]
  height: 1.0
  max_speed: 1.0
  max_acceleration: 1.0
  limits: [0, 16]
  locations: {start: 0, end: 16}
  start: start
  lanes:
    east: {origin: [2, 10]}
    north: {origin: [10, 2], heading: 1.5707963267948966}
"""
MOVES = """
duration: 60
traffic: false
people: [{name: ada, at: [1, 18]}]
agvs:
  east: [{time: 1, to: end}, {time: 30, to: start}]
  north: [{time: 1, to: end}]
"""


def test_agvs_that_cross_collide_once_per_meeting():
    """The AGVs meet at the crossing on the way there, and miss each other on the way back."""
    trial = sim.Trial.parse(on_floor(FLOOR, MOVES + "expect: {collisions: 0}\n"))
    run = sim.run(trial)
    (collision,) = events(run, "collision", machine="east", **{"with": "north"})
    # Full speed is reached after 1 s and 0.5 m. The crossing is 8 m away. The footprints meet half
    # a length and half a width before it, minus a millimetre of mere contact.
    assert collision["t"] == pytest.approx(1.0 + 0.5 + (8.0 - 1.0 + 0.001), abs=1e-6)
    assert collision["speed"] == pytest.approx(2**0.5)
    assert run.summary["collisions"] == 1
    assert [(verdict.met, verdict.time) for verdict in run.verdicts] == [(False, collision["t"])]


@pytest.mark.parametrize(("heading", "closing"), [(3.141592653589793, 2.0), (0.0, 0.0)])
def test_the_speed_of_a_collision_is_the_relative_speed(heading, closing):
    """Head on, and side by side on overlapping lanes."""
    at = "[18, 10]" if heading else "[2.5, 10]"
    floor = FLOOR.replace("origin: [10, 2], heading: 1.5707963267948966", f"origin: {at}")
    floor = floor.replace(f"origin: {at}", f"origin: {at}, heading: {heading}")
    run = sim.run(sim.Trial.parse(on_floor(floor, MOVES)))
    assert events(run, "collision")[0]["speed"] == pytest.approx(closing)


def test_overlapping_agvs_collide_once_at_the_start():
    inside = FLOOR.replace("[10, 2]", "[2.5, 9.5]")
    run = sim.run(sim.Trial.parse(on_floor(inside, MOVES)))
    assert [event["t"] for event in events(run, "collision")] == [0.0]


def test_gantries_collide_only_with_their_torsos():
    text = """
floorplan: ariac2023
duration: 60
traffic: false
people: [{name: ada, at: [-19, 0]}]
gantry: {controller: parked, at: [-6.0, 4.8, 0.0]}
agvs: {agv1: [{time: 1, to: assembly_back}]}
machines:
  other:
    kind: gantry
    x: [-14.0, -1.0]
    at: [-12.0, 4.8, 0.4]
    controller: oblivious
    jobs: [{move: [-2.0, 4.0, 0.4]}]
"""
    run = sim.run(sim.Trial.parse(text))
    (collision,) = events(run, "collision")
    assert (collision["machine"], collision["with"]) == ("gantry", "other")
    assert run.summary["collisions"] == 1


@pytest.mark.parametrize(("heading", "times"), [(0.0, []), (3.141592653589793, [8.501])])
def test_the_axis_of_a_vehicle_need_not_be_in_its_middle(heading, times):
    """An AGV passes behind a vehicle whose axis is near its rear, or hits its side in front."""
    text = f"""
duration: 20
traffic: false
agvs: {{north: [{{time: 1, to: end}}]}}
machines:
  long:
    kind: amr
    at: [10.9, 10, {heading}]
    footprint: [[-0.2, -0.4], [2, -0.4], [2, 0.4], [-0.2, 0.4]]
    controller: parked
"""
    run = sim.run(sim.Trial.parse(on_floor(FLOOR, text)))
    assert [event["t"] for event in events(run, "collision")] == pytest.approx(times)


WEDGE = "[[0.8, 0], [-0.4, 0.5], [-0.4, -0.5]]"
TEE = "[[-1, -0.2], [0, -0.2], [0, -0.8], [0.3, -0.8], [0.3, 0.8], [0, 0.8], [0, 0.2], [-1, 0.2]]"


@pytest.mark.parametrize(
    ("footprint", "place"), [(WEDGE, "[6.65, 4.4, 0]"), (TEE, "[5.55, 4.45, 0]")]
)
def test_machines_do_not_collide_beside_the_exact_footprint(footprint, place):
    """A small vehicle enters the bounding rectangle or hull of the other, but not its footprint."""
    text = f"""
duration: 30
traffic: false
machines:
  other: {{kind: amr, at: [6, 4, 0], footprint: {footprint}, controller: parked}}
  small: {{kind: amr, at: [3, 6, 0], size: [0.3, 0.3], missions: [{{go: {place}}}]}}
"""
    run = sim.run(sim.Trial.parse(on_floor(FLOOR, text)))
    assert len(events(run, "job_done")) == 1 and run.summary["collisions"] == 0


def test_machines_collide_when_their_exact_footprints_do():
    """The AGV is already within the hull of the T when it meets the bar."""
    text = f"""
duration: 20
traffic: false
agvs: {{east: [{{time: 1, to: end}}]}}
machines: {{other: {{kind: amr, at: [10, 11, 0], footprint: {TEE}, controller: parked}}}}
"""
    run = sim.run(sim.Trial.parse(on_floor(FLOOR, text)))
    (collision,) = events(run, "collision")
    assert collision["t"] == pytest.approx(1.0 + 0.5 + (7.4 + 0.001), abs=1e-6)


def test_machines_that_never_move_have_no_collision_figure():
    run = sim.run(sim.Trial.parse("{floorplan: ariac2023, duration: 5, people: [{name: ada}]}"))
    assert "collisions" not in run.summary


def contacts(trial, at, floor=None):
    """Return the number of contacts with a recorded person, who stands still throughout."""
    track = navigation.Motion.from_samples(t=[0.0, 60.0], xy=[at, at])
    people = (sim.PersonEntry("ada", recorded=track),)
    run = sim.run(replace(trial, people=people, floorplan=floor or trial.floorplan))
    return run.summary["contacts"]


def test_contacts_of_a_machine_with_people_are_counted():
    """On the lane, and beside it slightly closer and farther than the radius and half a width."""
    trial = sim.Trial.parse(on_floor(FLOOR, MOVES + "rules: observe\n"))
    assert [contacts(trial, (6.0, y)) for y in (10.0, 10.699, 10.701)] == [2, 2, 0]


def test_the_torso_of_a_gantry_touches_tall_people_only():
    trial = sim.Trial.parse("""
floorplan: ariac2023
duration: 20
rules: observe
gantry: {controller: oblivious, at: [-9.0, 0.0, 0.0], jobs: [{move: [-3.0, 0.0, 0.0]}]}
""")
    plan = trial.floorplan
    small = replace(plan, human=replace(plan.human, height=1.2))
    assert contacts(trial, (-6.0, 0.0)) == 1
    assert contacts(trial, (-6.0, 0.0), small) == contacts(trial, (-6.0, 2.0)) == 0


def test_a_contact_that_lasts_to_the_end_of_the_trial_counts_once():
    trial = sim.Trial.parse(
        """
        floorplan: {boundary: [[0, 0], [20, 0], [20, 8], [0, 8]], safe_zone: {at: [1, 7]}}
        duration: 9.0
        rules: observe
        people: [{name: eve, personality: external, at: [9, 4.1], max_speed: 0.05}]
        machines: {fork: {kind: amr, at: [3, 4, 0], max_speed: 0.8, missions: [{go: [18, 4]}]}}
        """
    )
    (contact,) = [event for event in sim.run(trial).events if event["kind"] == "contact"]
    assert contact["person"] == "eve" and contact["t"] < 8.0
