"""Tasks of a gantry: the steps of its jobs, its gripper, and the poses of the steps."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any

from floorplan import Floorplan, Gantry, Point, UserError
from floorplan.files.dataclass import dataclass
from navigation import Motion

from ...core.clock import MOMENT, Alarm, Clock, Turn
from ...core.entries import Drop, Pose
from ...core.scenario import Job
from ...core.stage import Stage
from ..commanding import Drive
from ..tasks import Passing, Step, Task


@dataclass(frozen=True, kw_only=True)
class Handling:
    """Durations of handling in seconds, chosen because none are published."""

    pick: float = 2.0
    place: float = 2.0
    turn_over: float = 3.0
    insert: float = 4.0
    pick_tray: float = 3.0
    place_tray: float = 3.0
    change_tool: float = 3.0


def tasks_of(jobs: Iterable[Job], handling: Handling) -> list[Task]:
    """Return the jobs of a trial as tasks, in their order. Successive parts may be exchanged."""
    tasks: list[Task] = []
    for job in jobs:
        stage = tasks[-1].stage if tasks else 0
        if tasks and not (job.kind == tasks[-1].kind == "pick_place"):
            stage += 1
        tasks.append(Task(job.kind, _steps(job, handling), stage=stage, fields=_fields(job)))
    return tasks


def _fields(job: Job) -> dict[str, Any]:
    if job.kind == "pick_place":
        return {"part": job.part, "from": job.pick, "to": job.place}
    return {"order": job.order} if job.kind == "submit" else {}


def _steps(job: Job, handling: Handling) -> tuple[Step, ...]:
    if job.kind == "move":
        return (Step("move", target=job.target),)
    if job.kind == "wait":
        return (Step("wait", seconds=job.seconds),)
    if job.kind == "submit":
        return (Step("submit"),)
    return (
        Step("pick", seconds=handling.pick, place=job.pick),
        Step("place", seconds=handling.place, place=job.place),
    )


class Gripper:
    """Gripper that holds the part of a task, and calls `lost(task)` when it drops the part.

    Each drop occurs once, at a delay after the part was picked. The delay includes the time in
    which the gantry is stopped.
    """

    def __init__(self, clock: Clock, lost: Callable[[Task], None]) -> None:
        self._clock = clock
        self._lost = lost
        self.drops: list[Drop] = []
        """Parts that it drops, and their delays."""
        self._picked: Counter[str] = Counter()
        self._holds: Task | None = None
        self._slips = Alarm(clock, self._slip, Turn.MOTION_ENDS)

    @property
    def holds_part(self) -> bool:
        """Whether it holds a part."""
        return self._holds is not None

    def will_lose(self, drops: Iterable[Drop]) -> None:
        """Add drops."""
        self.drops += drops

    def close(self, task: Task) -> None:
        """Grip the part of `task`."""
        part = str(task.fields.get("part"))
        before = self._picked[part]
        self._picked[part] += 1
        self._holds = task
        delays = [drop.delay for drop in self.drops if (drop.part, drop.after) == (part, before)]
        delay = min(delays, default=None)
        self._slips.set(None if delay is None else self._clock.now + delay)

    def open(self) -> None:
        """Release the part."""
        self._holds = None
        self._slips.set(None)

    def _slip(self) -> None:
        task, self._holds = self._holds, None
        if task is not None:
            self._lost(task)


AHEAD = 0.2
"""Seconds before a part passes by at which the gantry should be at the place.

Controllers that observe people arrive up to two observations later than necessary.
"""

REACH = 1e-3
"""Metres. Distance from a place within which the gantry can handle a part there."""

GUESSES = 64
"""Most iterations for the meeting with a part on a conveyor. A few are enough."""


class Worksites:
    """Present poses (x, y, rotation) of a gantry for the steps of its tasks."""

    def __init__(self, stage: Stage, gantry: Gantry, drive: Drive) -> None:
        self._machines = stage.machines
        self._clock = stage.clock
        self._gantry = gantry
        self._drive = drive
        self._body = drive.body
        self._places = fixed_places(stage.floorplan)
        self._rendezvous: tuple[Passing | None, float] = (None, 0.0)
        """Part that it will pick on the conveyor, and the time of the meeting (s)."""

    def pose_for(self, step: Step, rotation: float | None = None) -> Pose | None:
        """Return the pose of a step, or None if out of reach now. `rotation` defaults to now's."""
        if step.target is not None:
            return step.target
        if step.passing is not None:
            return self._meeting(step.passing, step.seconds, rotation)
        if step.place is None:
            return self._body.state.position
        at = self._position_of(step.place)
        if at is None:
            return None
        return self.at(at[0] + step.offset[0], at[1] + step.offset[1], rotation)

    def at(self, x: float, y: float, rotation: float | None = None) -> Pose:
        """Return a pose at x, y. `rotation` defaults to the present one."""
        return (x, y, self._body.state.position[2] if rotation is None else rotation)

    def stands_at(self, step: Step) -> bool:
        """Return whether the gantry stands at the pose of a step."""
        pose = self.pose_for(step)
        moving = self._clock.now < self._body.motion.end
        return not (pose is None or moving or math.dist(pose[:2], self._body.at) > REACH)

    def comes_by(self, passing: Passing) -> float | None:
        """Return the time (s) at which a part passes the gantry, or None if it does not."""
        return passing.at(self._body.at, REACH)

    def _meeting(self, passing: Passing, seconds: float, rotation: float | None) -> Pose | None:
        """Return the pose of the earliest meeting with a part after `seconds`, or None.

        That is the present pose if the part passes here later. Elsewhere, gantry and part must
        arrive at the same time. Each guess is the arrival of the gantry at the position of the
        last guess. This converges, because the gantry is faster than the part.
        """
        track, now = passing.track, self._clock.now
        comes_by = self.comes_by(passing) if self._body.motion.end <= now else None
        if comes_by is not None and comes_by >= now + seconds:
            return self._body.state.position
        # A possible meeting stays, because a new one after each delay would never be reached.
        part, meeting = self._rendezvous
        if part is not passing or self._ready(track, meeting, seconds, rotation) > meeting:
            meeting = max(track.start, now) + seconds + AHEAD
            for _ in range(GUESSES):
                if meeting > track.end:
                    return None
                # The fixed point of meeting = arrival(position at `meeting`). Guesses increase.
                ready = self._ready(track, meeting, seconds, rotation) + AHEAD
                if ready <= meeting + MOMENT:
                    break
                meeting = ready
            self._rendezvous = passing, meeting
        return self.at(*track.state(meeting).at, rotation)

    def _ready(self, track: Motion, t: float, seconds: float, rotation: float | None) -> float:
        """Return the time (s) of a pick at the position that `track` has at `t`."""
        pose = self.at(*track.state(t).at, rotation)
        return self._drive.preview(pose, 1.0).end + seconds

    def _position_of(self, place: str) -> Point | None:
        """Return the position of an obstacle, a station or a vehicle of that name.

        None for a vehicle that drives, or is outside the range of the gantry.
        """
        vehicle = self._machines.get(place)
        if vehicle is not None and vehicle.shape.category == "vehicle":
            x, y = at = vehicle.body.at
            within = not self._gantry.faults((x, y, 0.0))
            return at if within and vehicle.body.motion.end <= self._clock.now else None
        if place not in self._places:
            raise UserError(f"no obstacle, station or AGV is called {place!r}")
        return self._places[place]


def fixed_places(plan: Floorplan) -> dict[str, Point]:
    """Return the positions (x, y) of stations, and the middles of obstacles, by name."""
    return plan.middles | {station.name: station.position for station in plan.stations}
