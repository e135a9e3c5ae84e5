"""Tasks of machines: their steps, and their order."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import KW_ONLY
from typing import Any

from simpy.events import Event

from floorplan import Point, UserError
from floorplan.files.dataclass import dataclass
from navigation import Motion

from ..core.clock import Clock
from ..core.entries import Pose


@dataclass(frozen=True)
class Passing:
    """A part that is picked while it passes on a conveyor, at constant velocity.

    It is on the conveyor during `track`. `taken()` is called when it is picked.
    """

    track: Motion
    taken: Callable[[], None]

    def at(self, point: Point, within: float) -> float | None:
        """Return the time (s) at which it passes a point `within` metres, or None."""
        (ax, ay), (bx, by) = (self.track.state(t).at for t in (self.track.start, self.track.end))
        length, (dx, dy) = math.dist((ax, ay), (bx, by)), (point[0] - ax, point[1] - ay)
        # At constant velocity, shares of length are shares of time. The cross product is the
        # distance from the track times its length.
        along = (dx * (bx - ax) + dy * (by - ay)) / length
        if abs(dx * (by - ay) - dy * (bx - ax)) > within * length or not 0 <= along <= length:
            return None
        return self.track.start + along / length * (self.track.end - self.track.start)


@dataclass(frozen=True)
class Step:
    """Step of a task: go to a pose, and work there for `seconds`.

    The pose is one of these, by default the present one:

    - `offset` metres (x, y) from the middle of the obstacle, station or AGV named `place`
    - `target` (x, y, rotation)
    - the meeting with a `passing` part
    """

    action: str
    _: KW_ONLY
    seconds: float = 0.0
    place: str | None = None
    offset: tuple[float, float] = (0.0, 0.0)
    target: Pose | None = None
    passing: Passing | None = None


class Task:
    """Task with `steps` that are done one after the other.

    Its events contain its `kind` and `fields`. A task waits for those of an earlier `stage` in its
    `group`, and while `ready()` is False. After its last step, `check()` returns additional steps.
    If there are none, `done()` is called. When the machine drops the part of the task, `lost()`
    returns the steps with which the task begins again. By default these are the same. The task is
    given up if there are none.
    """

    def __init__(
        self,
        kind: str,
        steps: Iterable[Step],
        *,
        stage: int = 0,
        fields: Mapping[str, Any] | None = None,
        ready: Callable[[], bool] = lambda: True,
        done: Callable[[], None] = lambda: None,
        check: Callable[[], tuple[Step, ...]] = lambda: (),
        lost: Callable[[], tuple[Step, ...]] | None = None,
    ) -> None:
        self.kind = kind
        self.steps = tuple(steps)
        self.stage = stage
        self.fields = dict(fields or {})
        self.ready = ready
        self.done = done
        self.given_up = False
        """Whether it has ended without being done."""
        self.check = check
        self.lost: Callable[[], tuple[Step, ...]] = self._same_steps if lost is None else lost
        self.group = 0
        self.number = 0
        """Its number among all tasks of its machine."""
        self.announced = False
        self._count(0)
        if not self.steps:
            raise UserError("a task needs at least one step")

    def __repr__(self) -> str:
        return f"<task {self.kind} {self.fields}>"

    def _count(self, done: int) -> None:
        self._steps_done = done
        self.begun = done > 0
        """Whether a step has been done."""
        self.finished = done == len(self.steps)
        """Whether all steps have been done."""

    @property
    def steps_left(self) -> tuple[Step, ...]:
        """Remaining steps."""
        return self.steps[self._steps_done :]

    @property
    def next_step(self) -> Step | None:
        """Next step, or None if it is finished."""
        return None if self.finished else self.steps[self._steps_done]

    def advance(self) -> None:
        """Count the next step as done."""
        self._count(self._steps_done + 1)

    def begin_again(self, steps: tuple[Step, ...]) -> None:
        """Replace the remaining steps."""
        self.steps = steps
        self._count(0)
        picked = [step.place for step in steps if step.action == "pick"]
        if picked and "from" in self.fields:
            self.fields["from"] = picked[0]

    def _same_steps(self) -> tuple[Step, ...]:
        return self.steps

    def give_up(self) -> None:
        """End it without its remaining steps."""
        self.given_up = True
        self.begin_again(())
        self.done()


class Tasks:
    """All tasks of a machine in groups. Each group is done by stages."""

    def __init__(self, clock: Clock) -> None:
        self.more_to_come = False
        self._clock = clock
        self._groups: list[tuple[bool, list[Task]]] = []
        self._groups_added = 0
        self._added: list[Task] = []
        self._waiting: list[Event] = []

    @property
    def open(self) -> tuple[Task, ...]:
        """Tasks that can be started or continued now, in order of preference."""
        return tuple(self._open())

    @property
    def unfinished(self) -> bool:
        """Whether a task is unfinished."""
        return any(not task.finished for _, group in self._groups for task in group)

    def _open(self) -> Iterator[Task]:
        for _, group in self._groups:
            for task in _current(group):
                if task.ready():
                    yield task

    def numbered(self, number: int) -> Task:
        """Return the task of that number. `UserError` if there is none."""
        if not 0 <= number < len(self._added):
            raise UserError(f"there is no task {number}")
        return self._added[number]

    def picking(self, passing: Passing) -> Iterator[Task]:
        """Yield the tasks whose next step is to pick this part."""
        for _, group in self._groups:
            for task in group:
                if task.next_step is not None and task.next_step.passing is passing:
                    yield task

    def add(self, tasks: Iterable[Task], *, first: bool = False) -> None:
        """Add a group of tasks, before others if `first`."""
        group = list(tasks)
        self._groups_added += 1
        for task in group:
            task.group, task.number = self._groups_added, len(self._added)
            self._added.append(task)
        if group:
            self._groups.append((first, group))
            self._groups.sort(key=lambda entry: not entry[0])
        self.reconsider()

    def next(self) -> Event:
        """Return an event that occurs when a task is open. Its value is the preferred task.

        The value is None if all tasks are finished and there will be no more.
        """
        event = self._clock.event()
        self._waiting.append(event)
        self.reconsider()
        return event

    def reconsider(self) -> None:
        """Notify controllers that wait for a task, after a change."""
        self._groups = [
            (first, group)
            for first, group in self._groups
            if not all(task.finished for task in group)
        ]
        if not self._waiting:
            return
        preferred = next(self._open(), None)
        if preferred is None and (self._groups or self.more_to_come):
            return
        waiting, self._waiting = self._waiting, []
        for event in waiting:
            event.succeed(preferred)


def _current(group: list[Task]) -> list[Task]:
    """Return the unfinished tasks of the lowest stage, started ones first."""
    begun: list[Task] = []
    others: list[Task] = []
    stage = math.inf
    for task in group:
        if not task.finished and task.stage <= stage:
            if task.stage < stage:
                stage = task.stage
                begun, others = [], []
            (begun if task.begun else others).append(task)
    return begun + others
