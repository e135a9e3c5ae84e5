"""The built-in scenes of vehicles among people."""

import math

import numpy as np
import pytest
import shapely
from run_events import events

import sim


def surfaces(run, person, machine, t):
    """Return distances between the surfaces of a person and a vehicle, sampled."""
    shape = run.scene.machine(machine)
    walk, drive = run.motions[person], run.motions[machine]
    places = shapely.points(walk.position(t))
    footprints = [
        shape.footprint(tuple(at), float(rotation))
        for at, rotation in zip(drive.position(t), drive.rotation(t), strict=True)
    ]
    return shapely.distance(places, footprints) - run.floorplan.human.radius


@pytest.mark.parametrize(
    "name",
    [
        "vehicles_corridor",
        "vehicles_crossing",
        "vehicles_dock",
        "vehicles_lift",
        pytest.param("vehicles_warehouse", marks=pytest.mark.slow),
    ],
)
def test_the_scenes_of_vehicles_meet_their_expectations(name):
    run = sim.run(sim.Trial.load(name))
    assert run.unmet == []
    assert events(run, "field_stop") and events(run, "field_slowdown")
    t = np.arange(0.0, run.duration, 0.25)
    for machine in run.trial.machines:
        moves = np.hypot(*run.motions[machine].velocity(t).T) > 0.0
        for person in run.trial.people:
            apart = surfaces(run, person.name, machine, t)
            assert apart[moves].min(initial=math.inf) > 0.05 - 1e-6
