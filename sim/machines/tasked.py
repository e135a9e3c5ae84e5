"""Machines with tasks: the commands to carry them out, and their rounds."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any

from simpy.events import Event, Process

from ..core.body import MachineShape, checked, commands
from ..core.clock import Alarm, Turn
from ..core.events import JobDone, JobStarted
from ..core.stage import Stage
from .arguments import instance
from .commanded import CommandedMachine
from .commanding import Drive, Steps
from .tasks import Task, Tasks


class TaskedMachine(CommandedMachine):
    """Machine whose controller carries out tasks."""

    FOR_CONTROLLERS = CommandedMachine.FOR_CONTROLLERS | {
        *("open_tasks", "next_task", "do", "locate", "handle")
    }

    def __init__(
        self,
        stage: Stage,
        shape: MachineShape,
        drive: Drive,
        controller: Callable[[Any], Steps],
        *,
        repeat: bool = False,
        every: float | None = None,
    ) -> None:
        super().__init__(stage, shape, drive, controller)
        self.tasks = Tasks(stage.clock)
        self.tasks.more_to_come = every is not None
        self.jobs_done = 0
        self._repeat = repeat
        self._every = every
        self._round: Sequence[Task] = ()
        self._round_began = -math.inf
        self._next_round = Alarm(stage.clock, self._begin_round, Turn.MOTION_ENDS)

    @property
    def open_tasks(self) -> tuple[Task, ...]:
        """Tasks that can be started or continued now, in order of preference."""
        return self.tasks.open

    @checked
    def next_task(self) -> Event:
        """Wait for a task.

        Returns
        -------
        Event
            Event to yield. Its value is the preferred open task, or None if there will be none.
        """
        self._interrupts.command_given()
        return self.tasks.next()

    @commands
    def do(self, task: Task) -> Process:
        """Carry out the remaining steps of a task.

        An interrupted step is repeated from its begin.

        Parameters
        ----------
        task : Task
            The task.

        Returns
        -------
        Process
            Event to yield. Its value is False if another command replaced this one, otherwise True.
        """
        instance("do(task)", task, Task)
        return self._command(self._do(task, self._drive.begin()))

    @abstractmethod
    def locate(self, task: Task) -> Event:
        """Start or continue a task, and wait until its next step is in reach.

        Parameters
        ----------
        task : Task
            The task.

        Returns
        -------
        Event
            Event to yield. Its value is the pose of the next step.
        """

    @abstractmethod
    def handle(self, task: Task) -> Process:
        """Carry out the next step of a task at the current pose.

        An interrupted step is repeated from its begin.

        Parameters
        ----------
        task : Task
            The task.

        Returns
        -------
        Process
            Event to yield. Its value is False if the machine is elsewhere or another command
            replaced this one, otherwise True.

        Raises
        ------
        ValueError
            If the task is done.
        """

    @abstractmethod
    def _do(self, task: Task, command: int) -> Steps:
        """Carry out the remaining steps of a task as a part of a command."""

    def _begin(self, task: Task) -> None:
        if not task.announced:
            task.announced = True
            self.record(JobStarted.of({"job": task.kind, **task.fields}))

    def _finish(self, task: Task) -> None:
        if not task.given_up:
            self._record_done(task)
        task.done()
        self._go_on()

    def _record_done(self, task: Task) -> None:
        self.jobs_done += 1
        self.record(JobDone.of({"job": task.kind, **task.fields}))

    def _go_on(self) -> None:
        """Start the next round if this one is over, and notify the controller."""
        if all(task.finished for task in self._round) and self.now > self._round_began:
            if self._every is not None:
                self._next_round.set(max(self._round_began + self._every, self.now))
            elif self._repeat:
                self._begin_round()
        self.tasks.reconsider()

    def _begin_round(self) -> None:
        """Add all tasks of the trial."""
        self._round_began = self.now
        self._round = self._new_round()
        self.tasks.add(self._round)

    @abstractmethod
    def _new_round(self) -> Sequence[Task]:
        """Return the tasks of a round."""
