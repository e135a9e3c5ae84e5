"""Scenes of people, and how Floorwalker and JuPedSim walk them: for `literature.py`.

A scene is a floor and walkers. Both programs have the same input and the same output: frames of
positions, as PedPy reads them. JuPedSim runs its collision-free speed model at 0.05 s, with its own
defaults except for the bodies and speeds of the scene. A goal counts as reached within 0.5 m there.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import jupedsim
import numpy as np
import pandas as pd
import pedpy
import shapely
from numpy.typing import NDArray

import bdi
import floorplan
import sim
from sim.core.scenario import Source

RADIUS, FREE_SPEED, SPREAD = 0.2, 1.34, 0.26
"""Metres, and m/s with their standard deviation: U. Weidmann, "Transporttechnik der Fussgänger",
ETH Zürich, 1993."""

RATE, STEP = 10, 0.05
"""Hz, of the frames; seconds, JuPedSim's step."""

REACH = 0.5
"""Metres. JuPedSim's people have reached a goal so near to it."""

Point = tuple[float, float]


@dataclass(frozen=True)
class Walker:
    """A person who walks from a place to goals, one after the other, and leaves at the last.

    Without goals they stand. They come onto the floor at `enters`, and set out at `sets_out`
    (seconds). `speed` is in m/s.
    """

    at: Point
    goals: tuple[Point, ...] = ()
    speed: float = FREE_SPEED
    enters: float = 0.0
    sets_out: float = 0.0


@dataclass(frozen=True)
class Scene:
    """A floor (metres), the walkers on it, and for how long (seconds) they walk."""

    floor: shapely.Polygon
    walkers: Sequence[Walker]
    duration: float


Program = Callable[[Scene], pedpy.TrajectoryData]
"""Walks a scene: frames with the walkers' numbers as `id`."""


def rectangle(
    length: float, width: float, *walls: tuple[float, float, float, float]
) -> shapely.Polygon:
    """A floor from the origin on, less walls (x0, y0, x1, y1)."""
    floor = shapely.box(0.0, 0.0, length, width)
    return floor.difference(shapely.union_all([shapely.box(*wall) for wall in walls]))


def floorwalker(scene: Scene) -> pedpy.TrajectoryData:
    """Walk a scene in Floorwalker."""
    run = sim.run(trial(scene))
    if run.summary.get("overlaps", 0):
        raise AssertionError(f"{run.summary['overlaps']} pairs of people overlap")
    names, motions = list(run.summary["people"]), run.motions
    rows = []
    for k, name in enumerate(names):
        begin, end = run.presence[name]
        frames = np.arange(math.ceil(begin * RATE - 1e-6), math.floor(end * RATE + 1e-6) + 1)
        rows.append(_frames(k, frames, motions[name].position(frames / RATE)))
    return _data(rows)


def trial(scene: Scene) -> sim.Trial:
    """Return the scene as a trial with the walkers p0, p1, …"""
    human = floorplan.Human(radius=RADIUS, max_speed=FREE_SPEED)
    plan = floorplan.Floorplan(name="floor", boundary=scene.floor, human=human)
    return sim.Trial(
        plan,
        duration=scene.duration,
        rules=sim.RULE_SETS["observe"],
        people=tuple(_entry(k, one) for k, one in enumerate(scene.walkers)),
    )


def _entry(k: int, one: Walker) -> sim.PersonEntry:
    if not one.goals:
        still = sim.PersonEntry(f"p{k}", personality=bdi.parse("stands."), at=one.at)
        return replace(still, manners=replace(still.manners, steps_aside=False))
    heads = ["+human_start", *(f"+work_completed({n})" for n in range(len(one.goals) - 1))]
    legs = [f"{head} <- move({x}, {y}, 0)." for head, (x, y) in zip(heads, one.goals, strict=True)]
    source = Source(one.at, rate=1e3, start=one.enters) if one.enters else None
    return sim.PersonEntry(
        f"p{k}",
        personality=bdi.parse("\n".join(legs)),
        start=sim.Start(one.sets_out),
        at=None if source else one.at,
        source=source,
        sink=one.goals[-1],
        max_speed=one.speed,
    )


def jupedsims(scene: Scene) -> pedpy.TrajectoryData:
    """Walk a scene in JuPedSim."""
    world = jupedsim.Simulation(
        model=jupedsim.CollisionFreeSpeedModel(), geometry=scene.floor, dt=STEP
    )
    journeys = {
        goals: _journey(world, scene.floor, goals)
        for goals in dict.fromkeys(one.goals for one in scene.walkers if one.goals)
    }
    somewhere = next(iter(journeys.values()))  # for standing people, because JuPedSim needs a goal
    waiting = dict(enumerate(scene.walkers))
    numbers: dict[int, int] = {}
    frames: dict[int, list[tuple[int, Point]]] = {k: [] for k in waiting}
    for step in range(round(scene.duration / STEP) + 1):
        now = step * STEP
        for k, one in list(waiting.items()):
            if now < one.enters:
                continue
            journey, stage = journeys.get(one.goals, somewhere)
            agent = jupedsim.CollisionFreeSpeedModelAgentParameters(
                position=one.at,
                radius=RADIUS,
                desired_speed=one.speed if one.goals and not one.sets_out else 0.0,
                journey_id=journey,
                stage_id=stage,
            )
            try:
                numbers[world.add_agent(agent)] = k
            except RuntimeError:  # a person stands there
                continue
            del waiting[k]
        for agent in world.agents():
            one = scene.walkers[numbers[agent.id]]
            if 0.0 < one.sets_out <= now:
                agent.model.desired_speed = one.speed
            if step % round(1 / RATE / STEP) == 0:
                frame = round(now * RATE)
                frames[numbers[agent.id]].append((frame, agent.position))
        if not waiting and world.agent_count() == 0:
            break
        world.iterate()
    return _data(
        [
            _frames(k, np.array([f for f, _ in rows]), np.array([at for _, at in rows]))
            for k, rows in frames.items()
            if rows
        ]
    )


def _journey(
    world: jupedsim.Simulation, floor: shapely.Polygon, goals: Sequence[Point]
) -> tuple[int, int]:
    exit_at = shapely.Point(goals[-1]).buffer(REACH).intersection(floor).convex_hull
    stages = [world.add_waypoint_stage(goal, REACH) for goal in goals[:-1]]
    stages.append(world.add_exit_stage(exit_at))
    journey = jupedsim.JourneyDescription(stages)
    for stage, following in itertools.pairwise(stages):
        journey.set_transition_for_stage(
            stage, jupedsim.Transition.create_fixed_transition(following)
        )
    return world.add_journey(journey), stages[0]


def _frames(k: int, frames: NDArray[np.int64], at: NDArray[np.float64]) -> pd.DataFrame:
    return pd.DataFrame({"id": k, "frame": frames, "x": at[:, 0], "y": at[:, 1]})


def _data(rows: Sequence[pd.DataFrame]) -> pedpy.TrajectoryData:
    return pedpy.TrajectoryData(data=pd.concat(rows, ignore_index=True), frame_rate=RATE)
