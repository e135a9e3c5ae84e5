"""Avoidable contacts with vehicles, by a search independent of the crowd.

The person could have braked and walked straight to a place of a grid, within the limits of people,
clear of walls, of the motions of vehicles known at that time, and of other people. All motions are
sampled.
"""

import math

import numpy as np
import shapely

import sim

STEP = 0.02
"""Time between samples, s."""

GRID = 0.25
"""Distance of the places of the grid, m."""

REACH = 5.0
"""Maximum distance of a place, m."""

BEFORE = 5.0
"""Time before a contact at which the first search is made, s."""

TOLERANCE = 0.005
"""Depth of a contact that counts, m."""

MOVES = 0.05
"""Minimum speed of a vehicle that runs into a person, m/s."""


def contacts(run):
    """Return person, vehicle, time (s) and depth (m) of the first contact of each pair."""
    times = np.arange(0.0, run.duration, 0.01)
    touches = []
    for machine in run.scene.machines:
        motion = run.motions[machine.name]
        drives = np.hypot(*motion.velocity(times)[:, :2].T) > MOVES
        for person in run.trial.people:
            walk = run.motions[person.name]
            radius = person.radius or run.floorplan.human.radius
            apart = gaps(walk.position(times), motion, machine.bounds, times)
            deep = (apart - radius < -TOLERANCE) & drives
            if deep.any():
                depth = radius - apart[deep].min()
                touches.append((person.name, machine.name, times[deep.argmax()], depth))
    return touches


def gaps(places, motion, bounds, times):
    """Return the distances of places (…, T, 2) from a rectangle that moves (T), m."""
    west, south, east, north = bounds
    offset = places - motion.position(times)
    c, s = np.cos(motion.rotation(times)), np.sin(motion.rotation(times))
    x = offset[..., 0] * c + offset[..., 1] * s
    y = offset[..., 1] * c - offset[..., 0] * s
    return np.hypot(
        np.maximum(np.maximum(west - x, x - east), 0.0),
        np.maximum(np.maximum(south - y, y - north), 0.0),
    )


def avoidable(trial, contact):
    """Return a time and a place to which the person could have walked, or None.

    The search repeats every half second while the person was in danger, which means that the known
    motions of the person and the vehicle met.
    """
    name, vehicle, met, _ = contact
    simulation = sim.Simulation(trial)
    for t in np.arange(max(met - BEFORE, 0.0), met, 0.5):
        simulation.advance(float(t))
        place = free_place(simulation, name, vehicle)
        if place is not None:
            return float(t), place
    return None


def free_place(simulation, name, vehicle):
    """Return a place that a person in danger can reach, or None."""
    now, plan = simulation.clock.now, simulation.trial.floorplan
    people = {person.name: person.walker.human for person in simulation.people}
    bodies = {person.name: person.body.motion for person in simulation.people}
    foreseen = {
        machine.name: machine.foreseen(now + 10.0) for machine in simulation.machines.values()
    }
    drives = {k: motion for k, motion in foreseen.items() if motion.end > now}
    end = max([now, *(motion.end for motion in (*drives.values(), *bodies.values()))])
    times = np.arange(now, end + STEP, STEP)
    human, me = people[name], bodies.pop(name)
    shapes = {k: simulation.machines[k].shape.bounds for k in drives}

    def free(places):
        """Return which of some walks (N, T, 2) meet nothing that moves."""
        clear = np.ones(len(places), dtype=bool)
        for k, motion in drives.items():
            apart = gaps(places, motion, shapes[k], times)
            # A person who is too close already must not come closer.
            least = np.minimum(human.radius, apart[:, :1])
            clear &= (apart >= least - 1e-9).all(axis=1)
        for other, motion in bodies.items():
            away = np.hypot(*np.moveaxis(places - motion.position(times), -1, 0))
            clear &= (away >= human.radius + people[other].radius + 0.006).all(axis=1)
        return clear

    if vehicle not in drives or free(me.position(times)[None])[0]:
        return None
    state = me.state(now)
    braking = state.speed / human.max_acceleration
    stop = np.array(state.at) + np.array(state.velocity[:2]) * braking / 2
    lattice = GRID * np.arange(math.ceil(-REACH / GRID), REACH / GRID + 1)
    grid = np.stack(np.meshgrid(*(np.round(c / GRID) * GRID + lattice for c in stop)), axis=-1)
    ends = grid.reshape(-1, 2)
    ends = ends[np.hypot(*(ends - stop).T) <= REACH]
    ends = ends[walkable(simulation, plan, human.radius, stop, ends)]
    walks = np.concatenate([[stop], ends])
    lengths = np.hypot(*(walks - stop).T)
    share = travelled(lengths, human, times - now - braking) / np.maximum(lengths, 1e-9)[:, None]
    places = stop + share[..., None] * (walks - stop)[:, None]
    slows = np.minimum(times - now, braking)
    before = (
        np.array(state.at)
        + np.array(state.velocity[:2]) * (slows - slows**2 / (2 * max(braking, 1e-9)))[:, None]
    )
    places[:, times - now < braking] = before[times - now < braking]
    clear = free(places)
    return tuple(walks[clear.argmax()].tolist()) if clear.any() else None


def walkable(simulation, plan, radius, start, ends):
    """Return which straight lines are clear of walls and of stationary machines."""
    room = plan.boundary.difference(shapely.union_all([one.footprint for one in plan.obstacles]))
    now = simulation.clock.now
    for machine in simulation.machines.values():
        motion = machine.foreseen(now + 10.0)
        if machine.shape.category == "vehicle" and motion.end <= now:
            state = motion.state(now)
            room = room.difference(machine.shape.footprint(state.at, state.position[2]))
    lines = shapely.linestrings([(start, end) for end in ends])
    return shapely.covers(room.buffer(-radius + 1e-3), lines)


def travelled(lengths, human, times):
    """Return the distances walked from rest on walks of some lengths (N) at times (T), m."""
    top, gain = human.max_speed, human.max_acceleration
    peak = np.minimum(top, np.sqrt(gain * lengths))[:, None]
    rising = peak / gain
    cruise = np.maximum(lengths[:, None] / np.maximum(peak, 1e-9) - rising, 0.0)
    t = np.maximum(times, 0.0)[None]
    rise, level = np.minimum(t, rising), np.clip(t - rising, 0.0, cruise)
    slow = np.clip(t - rising - cruise, 0.0, rising)
    return gain * rise**2 / 2 + peak * level + peak * slow - gain * slow**2 / 2
