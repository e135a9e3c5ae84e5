"""People and vehicles: nobody walks into one, and one that yields runs into nobody."""

from navigation import Cylinder, FixedDistance, Shapes, TooClose, first_time

HAIR = 1e-6
"""Metres, and seconds."""

SLACK = 1e-5
"""Metres. Who stands as close as that to an AGV that stands is beside it, and clear of it."""

STANDS = 1e-3
"""m/s. Who is no faster than this stands."""


def contact_faults(run):
    """Return who touches a vehicle, but for who stands where one drives that does not yield."""
    human = run.trial.floorplan.human
    for entry in run.trial.people:
        person = run.motions[entry.name]
        solid = Cylinder(radius=(entry.radius or human.radius) - SLACK, top=human.height)
        for vehicle in run.scene.machines:
            if vehicle.category != "vehicle":
                continue
            agv, box = run.motions[vehicle.name], vehicle.box
            shapes = Shapes(person=solid, machine=(box,))
            touch = TooClose(FixedDistance(HAIR))
            t = first_time(touch, person, agv, 0.0, run.duration, shapes=shapes)
            if t is None or (
                t == 0.0 and entry.place_on(run.floorplan) is not None
            ):  # they start like that
                continue
            before = max(t - HAIR, 0.0)
            walks, drives = (one.state(before).speed > STANDS for one in (person, agv))
            turned = agv.rotation([before, t])
            if turned[0] != turned[1]:  # it turns on the spot, into whoever is beside it
                continue
            if walks or not drives or yields(run.trial, vehicle.name):
                yield f"{entry.name} touches {vehicle.name} at t = {t:.6f} s"


def yields(trial, name):
    """Return whether an AGV stops for people."""
    machine = trial.machines.get(name)
    return name in trial.yielding if machine is None else machine.keys.get("yield", False)
