"""People and vehicles: no person walks into a vehicle, and a yielding vehicle hits no person."""

from navigation import Cylinder, FixedDistance, Shapes, TooClose, first_time

HAIR = 1e-6
"""Metres, and seconds."""

SLACK = 1e-5
"""m. A standing person this close to a standing AGV is beside it, and clear of it."""

STANDS = 1e-3
"""m/s. A slower body stands."""


def contact_faults(run):
    """Return contacts, except of standing people with a moving vehicle that does not yield."""
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
            ):  # the trial starts like that
                continue
            before = max(t - HAIR, 0.0)
            walks, drives = (one.state(before).speed > STANDS for one in (person, agv))
            turned = agv.rotation([before, t])
            if turned[0] != turned[1]:  # the vehicle turns on the spot, into a person beside it
                continue
            if walks or not drives or yields(run.trial, vehicle.name):
                yield f"{entry.name} touches {vehicle.name} at t = {t:.6f} s"


def yields(trial, name):
    """Return whether an AGV stops for people."""
    machine = trial.machines.get(name)
    return name in trial.yielding if machine is None else machine.keys.get("yield", False)
