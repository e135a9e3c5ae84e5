"""Tasks of machines with a controller: their steps, and the order in which they are done."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any

from simpy.events import Event

from floorplan import Point, UserError
from navigation import Motion

from ..core.clock import Clock
from ..core.entries import Pose


@dataclass(frozen=True)
class Passing:
    """Something that is picked while it goes by, straight on and steadily.

    It lies on a conveyor during `track`, and `taken()` is called when it is picked.
    """

    track: Motion
    taken: Callable[[], None]

    def at(self, point: Point, within: float) -> float | None:
        """Return the instant (s) at which it comes by a point, `within` metres; None if never."""
        (ax, ay), (bx, by) = (self.track.state(t).at for t in (self.track.start, self.track.end))
        length, (dx, dy) = math.dist((ax, ay), (bx, by)), (point[0] - ax, point[1] - ay)
        # Straight and steady: the share of the track's length is that of its time, too. The cross
        # product is the distance from the track, times its length.
        along = (dx * (bx - ax) + dy * (by - ay)) / length
        if abs(dx * (by - ay) - dy * (bx - ax)) > within * length or not 0 <= along <= length:
            return None
        return self.track.start + along / length * (self.track.end - self.track.start)


@dataclass(frozen=True)
class Step:
    """One errand of a task: go somewhere, and handle something there for `seconds`.

    It is at the obstacle, station or AGV named `place`, `offset` metres (x, y) from its
    middle; or at `target` (x, y, rotation); or where it meets what is `passing`; or, with none of
    them, wherever the gantry is.
    """

    action: str
    _: KW_ONLY
    seconds: float = 0.0
    place: str | None = None
    offset: tuple[float, float] = (0.0, 0.0)
    target: Pose | None = None
    passing: Passing | None = None


class Task:
    """Something to be done in `steps`, one after the other.

    `kind` and `fields` go into its events. A task of a later `stage` waits for
    those before it in its `group`; `ready()` is True while it may be begun as things stand.
    After its last step `check()` returns what more there is to be done for it, and if that is
    nothing `done()` is called. Where the part that it carries is `lost()`, that returns the steps
    with which it begins again: the same ones by default, or none if it has to be given up.
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
        """Whether there is nothing more to be done for it, though it is not done."""
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
        """Whether a step of it has been done."""
        self.finished = done == len(self.steps)
        """Whether all of it has been done."""

    @property
    def steps_left(self) -> tuple[Step, ...]:
        """Steps that have to be done yet."""
        return self.steps[self._steps_done :]

    @property
    def next_step(self) -> Step | None:
        """Step that has to be done next; None once it is finished."""
        return None if self.finished else self.steps[self._steps_done]

    def advance(self) -> None:
        """Take note that the next step has been done."""
        self._count(self._steps_done + 1)

    def begin_again(self, steps: tuple[Step, ...]) -> None:
        """Do these `steps` from now on, instead of those that are left."""
        self.steps = steps
        self._count(0)
        picked = [step.place for step in steps if step.action == "pick"]
        if picked and "from" in self.fields:
            self.fields["from"] = picked[0]

    def _same_steps(self) -> tuple[Step, ...]:
        return self.steps

    def give_up(self) -> None:
        """Let there be nothing more to be done for it."""
        self.given_up = True
        self.begin_again(())
        self.done()


class Tasks:
    """All tasks of a machine, in groups; of a group, one stage at a time."""

    def __init__(self, clock: Clock) -> None:
        self.more_to_come = False
        self._clock = clock
        self._groups: list[tuple[bool, list[Task]]] = []
        self._groups_added = 0
        self._added: list[Task] = []
        self._waiting: list[Event] = []

    @property
    def open(self) -> tuple[Task, ...]:
        """The tasks that may be begun or gone on with now, the preferred one first."""
        return tuple(self._open())

    @property
    def unfinished(self) -> bool:
        """Whether there is something to be done yet."""
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
        """Yield the tasks whose next step is to pick it."""
        for _, group in self._groups:
            for task in group:
                if task.next_step is not None and task.next_step.passing is passing:
                    yield task

    def add(self, tasks: Iterable[Task], *, first: bool = False) -> None:
        """Add a group of tasks; `first` puts it before all others that were not put first."""
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
        """Return an event that happens once a task is open; its value is the preferred one.

        The value is None when everything is done and nothing more will come.
        """
        event = self._clock.event()
        self._waiting.append(event)
        self.reconsider()
        return event

    def reconsider(self) -> None:
        """Answer those who wait for a task: something has changed."""
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
    """Return the unfinished tasks of the lowest stage, with those that were begun in front."""
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
