"""Tasks of the gantry: its jobs in steps, the gripper that does them, and the poses for them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from floorplan import Floorplan, Gantry, Point, UserError
from navigation import Motion

from ...core.clock import MOMENT, Alarm, Clock, Turn
from ...core.entries import Drop, Pose
from ...core.scenario import Job
from ...core.stage import Stage
from ..commanding import Drive
from ..tasks import Passing, Step, Task


@dataclass(frozen=True, kw_only=True)
class Handling:
    """Times that the gantry's hand takes, seconds (our choice; none are published)."""

    pick: float = 2.0
    place: float = 2.0
    turn_over: float = 3.0
    insert: float = 4.0
    pick_tray: float = 3.0
    place_tray: float = 3.0
    change_tool: float = 3.0


def tasks_of(jobs: Iterable[Job], handling: Handling) -> list[Task]:
    """Return the jobs of a trial as tasks: in their order, but neighbouring parts in any order."""
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
    """Holds what was picked for a task, and calls `lost(task)` when it loses that.

    It loses a part by each of its drops once. How long it has held it counts in simulated time,
    also while the gantry stands.
    """

    def __init__(self, clock: Clock, lost: Callable[[Task], None]) -> None:
        self._clock = clock
        self._lost = lost
        self.drops: list[Drop] = []
        """The parts that it loses."""
        self._picked: Counter[str] = Counter()
        self._holds: Task | None = None
        self._slips = Alarm(clock, self._slip, Turn.MOTION_ENDS)

    @property
    def holds_part(self) -> bool:
        """Whether it holds something."""
        return self._holds is not None

    def will_lose(self, drops: Iterable[Drop]) -> None:
        """Lose parts by these drops as well."""
        self.drops += drops

    def close(self, task: Task) -> None:
        """Hold the part that was picked for `task`."""
        part = str(task.fields.get("part"))
        before = self._picked[part]
        self._picked[part] += 1
        self._holds = task
        delays = [drop.delay for drop in self.drops if (drop.part, drop.after) == (part, before)]
        delay = min(delays, default=None)
        self._slips.set(None if delay is None else self._clock.now + delay)

    def open(self) -> None:
        """Hold nothing any more."""
        self._holds = None
        self._slips.set(None)

    def _slip(self) -> None:
        task, self._holds = self._holds, None
        if task is not None:
            self._lost(task)


AHEAD = 0.2
"""Seconds that the gantry is to be at a place before something comes by that it picks there.

Controllers that look where people are take up to two observations longer than they need.
"""

REACH = 1e-3
"""Metres. Distance of the gantry's axis from a place within which it can handle something there."""

GUESSES = 64
"""Of where the gantry meets what comes along a conveyor; a few are enough."""


class Worksites:
    """Poses (x, y, rotation) of a gantry for the steps of its tasks, as things stand now."""

    def __init__(self, stage: Stage, gantry: Gantry, drive: Drive) -> None:
        self._machines = stage.machines
        self._clock = stage.clock
        self._gantry = gantry
        self._drive = drive
        self._body = drive.body
        self._places = fixed_places(stage.floorplan)
        self._rendezvous: tuple[Passing | None, float] = (None, 0.0)
        """What it is to pick as it goes by, and when (s)."""

    def pose_for(self, step: Step, rotation: float | None = None) -> Pose | None:
        """Return the pose of a step; None if out of reach now. `rotation` is kept if not given."""
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
        """Return a pose at x, y; `rotation` is kept if not given."""
        return (x, y, self._body.state.position[2] if rotation is None else rotation)

    def stands_at(self, step: Step) -> bool:
        """Return True if the gantry stands where `step` can be handled."""
        pose = self.pose_for(step)
        moving = self._clock.now < self._body.motion.end
        return not (pose is None or moving or math.dist(pose[:2], self._body.at) > REACH)

    def comes_by(self, passing: Passing) -> float | None:
        """Return the instant (s) at which it comes by where the gantry is; None if never."""
        return passing.at(self._body.at, REACH)

    def _meeting(self, passing: Passing, seconds: float, rotation: float | None) -> Pose | None:
        """Return the pose at which it can be picked first, after `seconds`; None if it can't be.

        That is here, where it has yet to come by. Elsewhere the meeting is where the gantry and
        what it picks come at the same time: each guess is that of the gantry's arrival at the last
        one, which converges, as the gantry is the faster of the two.
        """
        track, now = passing.track, self._clock.now
        comes_by = self.comes_by(passing) if self._body.motion.end <= now else None
        if comes_by is not None and comes_by >= now + seconds:
            return self._body.state.position
        # The last one stands while it can be kept: a new one for each delay would not be reached.
        meant, meeting = self._rendezvous
        if meant is not passing or self._ready(track, meeting, seconds, rotation) > meeting:
            meeting = max(track.start, now) + seconds + AHEAD
            for _ in range(GUESSES):
                if meeting > track.end:
                    return None
                # A fixed point of meeting = arrival(where it is at `meeting`): each guess is later
                # than the last.
                ready = self._ready(track, meeting, seconds, rotation) + AHEAD
                if ready <= meeting + MOMENT:
                    break
                meeting = ready
            self._rendezvous = passing, meeting
        return self.at(*track.state(meeting).at, rotation)

    def _ready(self, track: Motion, t: float, seconds: float, rotation: float | None) -> float:
        """Return the instant (s) at which it could have picked what is on `track` at `t` there."""
        pose = self.at(*track.state(t).at, rotation)
        return self._drive.preview(pose, 1.0).end + seconds

    def _position_of(self, place: str) -> Point | None:
        """Return the position of an obstacle, a station or a vehicle of that name.

        None for a vehicle that drives, or stands beyond the gantry's range.
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
    """Return the places (x, y) of stations, and the middles of obstacles, by name."""
    return plan.middles | {station.name: station.position for station in plan.stations}
