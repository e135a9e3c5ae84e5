"""People and AGVs: nobody walks into one, and one that yields runs into nobody."""

from navigation import Cylinder, FixedDistance, Shapes, TooClose, first_time

HAIR = 1e-6
"""Metres, and seconds."""

SLACK = 1e-5
"""Metres. Who stands as close as that to an AGV that stands is beside it, and clear of it."""

STANDS = 1e-3
"""m/s. Who is no faster than this stands."""


def contact_faults(run):
    """Return who touches an AGV, but for who stands before one that drives and does not yield."""
    human = run.trial.floorplan.human
    for entry in run.trial.people:
        person = run.motions[entry.name]
        solid = Cylinder(radius=(entry.radius or human.radius) - SLACK, top=human.height)
        for lane in run.trial.floorplan.lanes:
            agv, box = run.motions[lane.name], run.scene.machine(lane.name).box
            shapes = Shapes(person=solid, machine=(box,))
            touch = TooClose(FixedDistance(HAIR))
            t = first_time(touch, person, agv, 0.0, run.duration, shapes=shapes)
            if t is None or (
                t == 0.0 and entry.place_on(run.floorplan) is not None
            ):  # they start like that
                continue
            before = max(t - HAIR, 0.0)
            walks, drives = (one.state(before).speed > STANDS for one in (person, agv))
            if walks or not drives or lane.name in run.trial.yielding:
                yield f"{entry.name} touches {lane.name} at t = {t:.6f} s"
