"""Minimisation of a trial that breaks an objective: few entries, short, round values.

Delta debugging on the entries of a trial (A. Zeller and R. Hildebrandt, "Simplifying and isolating
failure-inducing input", IEEE Transactions on Software Engineering 28, 2002). Every part that the
break does not need is removed, large parts first.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from typing import Any, TypeVar

from floorplan import UserError
from floorplan.files.dataclass import dataclass

from ..core.entries import is_number
from ..core.scenario import Job, PersonEntry, Scenario
from ..machines.gantry.robot import GANTRY
from ..runs.run import Run
from ..simulation import run
from ..studies.variables import variable
from ..trials.building import lasting
from ..trials.paths import places, value_at, with_value
from ..trials.trial import Trial
from .objective import Objective, Situation, makes_no_trial

MOST_RUNS = 200
"""Maximum number of runs of one minimisation."""

AFTER = 1.0
"""Seconds that a minimised trial lasts after its worst time."""

TESTED = ("controller", "rate")
"""Keys of a machine that are tested."""

OF_A_PERSON = ("personality", "start", "at", "recorded", "source")
"""Keys of a person that change their behaviour most, and are removed first."""

ROUNDED = (
    "gantry.at.*",
    "people.*.start.time",
    "people.*.max_speed",
    "people.*.at.*",
    "machines.*.at.*",
    "gantry.jobs.*.seconds",
    "agvs.*.*.time",
    "blackouts.*.start.time",
    "blackouts.*.seconds",
    "commands.*.time",
)
"""Paths of numbers that are rounded."""

LISTS = ("missions", "moves")
"""Keys of machines that are lists of entries."""

_Entry = TypeVar("_Entry")

Candidate = Trial | None
"""A smaller trial, or None if there is none."""


@dataclass(frozen=True)
class Minimised:
    """A minimised trial: the number of runs it took, its value, and the situation."""

    trial: Trial
    runs: int
    value: float | None
    situation: Situation


class Minimiser:
    """Minimises one trial. `paths` are further numbers to round, as in a study."""

    def __init__(
        self, trial: Trial, objective: Objective, paths: Sequence[str] = (), most: int = MOST_RUNS
    ) -> None:
        self.runs = 0
        self._objective = objective.of_expected()
        self._paths = paths
        self._most = most
        self._error = ""
        self._best = objective.expected(trial)
        self._value: float | None = None
        self._situation = Situation()
        self._failed: list[Trial] = []
        """Trials that do not break the objective."""
        self._run: Run | None = None
        """Run of the smallest trial so far, unless it raised an error."""

    def minimised(self) -> Minimised | None:
        """Return the smallest trial that breaks the objective, or None if the first does not."""
        if not self._breaks(self._best, first=True):
            return None
        before: Candidate = None
        while self._best != before and self.runs < self._most:
            before = self._best
            self._end_early()
            self._events()
            self._people()
            self._machines()
            if not self._proves_nothing:
                self._jobs()
            self._keys_of_people()
            self._keys_of_machines()
            self._others()
        for digits in (0, 1, 2):
            self._round(digits)
        if self._best.seed:
            self._try(replace(self._best, seed=0))
        self._end_early()
        return Minimised(self._best, self.runs, self._value, self._situation)

    def _try(self, candidate: Candidate) -> bool:
        """Replace the trial by a candidate that still breaks the objective."""
        if candidate is None or candidate == self._best or candidate in self._failed:
            return False
        if not self._breaks(candidate):
            self._failed.append(candidate)
            return False
        self._best = candidate
        return True

    def _try_with(self, path: str, value: Any) -> bool:
        """Replace a value of the trial, if the result is valid and breaks the objective."""
        try:
            return self._try(with_value(self._best, path, value))
        except (UserError, ValueError, TypeError):
            return False

    def _breaks(self, trial: Trial, *, first: bool = False) -> bool:
        """Return True if a trial breaks the objective as the first did, and record its value."""
        if self.runs >= self._most:
            return False
        self.runs += 1
        try:
            finished = run(trial)
            value = self._objective.value(finished)
        except Exception as why:  # custom controllers may raise anything
            kind = type(why).__name__
            if makes_no_trial(why) or not (first or self._error == kind):
                return False
            self._error = kind
            return True
        if self._error or not self._objective.is_broken_by(value):
            return False
        self._value, self._situation = value, self._objective.situation(finished)
        self._run = finished
        return True

    @cached_property
    def _proves_nothing(self) -> bool:
        """True if a trial without work breaks the objective, so that less work proves nothing.

        An expectation of jobs to be done is an example.
        """
        if self._error:
            return False
        before, best = (self._value, self._situation, self._run), self._best
        gantry = replace(best.gantry, jobs=())
        nothing = lasting(replace(best, gantry=gantry, agvs={}), min(1.0, best.duration))
        breaks = self._breaks(nothing)
        self._value, self._situation, self._run = before
        return breaks

    def _end_early(self) -> None:
        """End the trial soon after it breaks, at one of the times of its run if there are any."""
        if self._proves_nothing:
            return
        times = [] if self._run is None else self._objective.instants(self._run)
        ends = sorted({float(math.ceil(time + AFTER)) for time in times})
        ends = ends or [float(k) for k in range(1, math.ceil(self._best.duration))]
        low, high = 0, len(ends)
        while low < high:
            middle = (low + high) // 2
            seconds = ends[middle]
            if seconds >= self._best.duration or self._try(lasting(self._best, seconds)):
                high = middle
            else:
                low = middle + 1

    def _people(self) -> None:
        everybody = self._best.people
        alone = tuple(p for p in everybody if p.name == self._situation.person and p.group is None)
        if alone and len(everybody) > 1:
            self._try_with("people", alone)
        self._remove("people")

    def _machines(self) -> None:
        self._try(replace(self._best, agvs={}, yielding=frozenset()))
        for name in [*self._best.agvs]:
            self._try_with("agvs", _without(self._best.agvs, name))
        for name in [*self._best.agvs]:
            self._remove(f"agvs.{name}")
        for name in [*self._best.machines]:
            fields = _without(self._best.fields, name)
            machines = _without(self._best.machines, name)
            with suppress(UserError, ValueError, TypeError):
                self._try(replace(self._best, machines=machines, fields=fields))

    def _jobs(self) -> None:
        gantry = self._best.gantry
        self._try(replace(self._best, gantry=replace(gantry, jobs=(), drops=(), repeat=False)))
        self._try_with("gantry.repeat", False)
        self._remove("gantry.jobs")
        self._skip_ahead()

    def _skip_ahead(self) -> None:
        """Replace the gantry's first jobs by a wait of their duration at their last position.

        The break may need the time at which a job begins, and not the jobs before it.
        """
        jobs = self._best.gantry.jobs
        if self._run is None or GANTRY not in self._run.motions:
            return
        done = [event["t"] for event in self._run.events if event["kind"] == "job_done"]
        for k in range(min(len(done), len(jobs) - 1), 1, -1):
            seconds = round(done[k - 1], 2)
            x, y, rotation = self._run.motions[GANTRY].state(seconds).position
            waiting = Job("wait", seconds=seconds)
            at = (round(x, 3), round(y, 3), round(rotation, 3))
            gantry = replace(self._best.gantry, at=at, jobs=(waiting, *jobs[k:]))
            if self._try(replace(self._best, gantry=gantry)):
                return

    def _events(self) -> None:
        """Remove other events of the trial."""
        self._try(
            replace(
                self._best,
                blackouts=(),
                obstacles=(),
                commands=(),
                doors={},
                gantry=replace(self._best.gantry, drops=()),
            )
        )
        for key in ("blackouts", "obstacles", "commands"):
            self._remove(key)
        for name in [*self._best.doors]:
            self._try_with("doors", _without(self._best.doors, name))

    def _keys_of_people(self) -> None:
        """Remove keys of people: all but the important ones at once, then one by one."""
        for k, person in enumerate(self._best.people):
            plain = PersonEntry(name=person.name)
            important = {key: getattr(person, key) for key in OF_A_PERSON}
            self._try_with(f"people.{k}", replace(plain, **important))
            for key, value in vars(plain).items():
                self._try_with(f"people.{k}.{key}", value)

    def _keys_of_machines(self) -> None:
        """Remove keys of machines that are not tested, or entries of their lists."""
        for name, entry in self._best.machines.items():
            for key in [key for key in entry.keys if key not in TESTED]:
                path = f"machines.{name}.keys"
                rest = _without(value_at(self._best, path), key)
                if not self._try_with(path, rest) and key in LISTS:
                    self._remove(f"{path}.{key}")

    def _others(self) -> None:
        """Remove the other keys of the trial and of the gantry."""
        plain = Scenario(self._best.floorplan)
        for key in ("work", "sources", "workload", "warm_up", "planner"):
            self._try_with(key, getattr(plain, key))
        self._try_with("gantry.at", None)

    def _remove(self, path: str) -> None:
        """Remove as many entries as possible: halves first, then quarters, then one by one."""
        size = max(len(value_at(self._best, path)) // 2, 1)
        while size and value_at(self._best, path):
            k = 0
            while k < len(entries := value_at(self._best, path)):
                if not self._try_with(path, entries[:k] + entries[k + size :]):
                    k += size
            size //= 2

    def _round(self, digits: int) -> None:
        """Round all numbers to `digits` decimals, together or otherwise one by one."""
        paths: dict[str, None] = {}
        for path in (*ROUNDED, *self._paths):
            with suppress(UserError):
                paths |= dict.fromkeys(places(self._best, path))
        together = self._best
        for path in paths:
            together = _rounded(together, path, digits) or together
        if not self._try(together):
            for path in paths:
                self._try(_rounded(self._best, path, digits))


def _rounded(trial: Trial, path: str, digits: int) -> Candidate:
    """Return the trial with a rounded number, or None if that changes nothing or is invalid."""
    number = value_at(trial, path)
    if not is_number(number) or round(number, digits) == number:
        return None
    value = float(round(number, digits)) + 0.0  # no negative zero
    try:
        return variable(path).put(trial, value, trial.folder)
    except ValueError:
        return None


def _without(entries: Mapping[str, _Entry], name: str) -> dict[str, _Entry]:
    return {other: entry for other, entry in entries.items() if other != name}
