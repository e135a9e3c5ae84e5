"""Minimisation of a trial that breaks an objective: fewest entries, shortest, roundest values.

Delta debugging on the entries of a trial (A. Zeller and R. Hildebrandt, "Simplifying and isolating
failure-inducing input", IEEE Transactions on Software Engineering 28, 2002): whatever can be left
out without the trial being met is left out, in large parts first.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeVar

from floorplan import Point, UserError

from ..core.entries import Start, is_number
from ..core.scenario import Job, PersonEntry, Scenario
from ..core.stage import MachineEntry
from ..machines.gantry.robot import GANTRY
from ..runs.run import Run
from ..simulation import run
from ..studies.variables import put_at
from ..trials.building import lasting
from ..trials.trial import Trial
from .objective import Objective, Situation, makes_no_trial

MOST_RUNS = 200
"""Number of runs that the minimisation of one trial takes at most."""

AFTER = 1.0
"""Seconds that a minimised trial lasts beyond the instant at which it is worst."""

TESTED = ("controller", "rate")
"""Keys of a machine that make up what is tested."""

OF_A_PERSON = ("personality", "start", "at", "recorded", "source")
"""Keys of a person without which people differ most from those that broke the objective."""

LISTS = ("missions", "moves")
"""Keys of machines that are lists of entries."""

_Entry = TypeVar("_Entry")

Candidate = Trial | None
"""A smaller trial, or None where there is none."""


@dataclass(frozen=True)
class Minimised:
    """A minimised trial: how many runs it took, its value, and the situation."""

    trial: Trial
    runs: int
    value: float | None
    situation: Situation


class Minimiser:
    """Minimises one trial; `paths` are those of numbers to be rounded (as in a study)."""

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
        """Trials that do not break it."""
        self._run: Run | None = None
        """The run of the smallest trial so far, unless it raised an error."""

    def minimised(self) -> Minimised | None:
        """Return the smallest trial found that still breaks the objective; None if it does not."""
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
        """Take a candidate if it still breaks the objective."""
        if candidate is None or candidate == self._best or candidate in self._failed:
            return False
        if not self._breaks(candidate):
            self._failed.append(candidate)
            return False
        self._best = candidate
        return True

    def _try_with(self, **entries: Any) -> bool:
        """Take the trial with other entries, if it is one and still breaks the objective."""
        try:
            return self._try(replace(self._best, **entries))
        except (UserError, ValueError, TypeError):
            return False

    def _breaks(self, trial: Trial, *, first: bool = False) -> bool:
        """Return whether a trial breaks the objective as the first one did, and note its value."""
        if self.runs >= self._most:
            return False
        self.runs += 1
        try:
            finished = run(trial)
            value = self._objective.value(finished)
        except Exception as why:  # somebody's controller may raise anything
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
        """Whether nothing at all breaks the objective: then less work and time prove nothing.

        So it is with an expectation of jobs that are to be done.
        """
        if self._error:
            return False
        kept, best = (self._value, self._situation, self._run), self._best
        gantry = replace(best.gantry, jobs=())
        nothing = lasting(replace(best, gantry=gantry, agvs={}), min(1.0, best.duration))
        found = self._breaks(nothing)
        self._value, self._situation, self._run = kept
        return found

    def _end_early(self) -> None:
        """Let the trial end soon after it breaks: at one of the times that its run says, if any."""
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
        alone = [p for p in everybody if p.name == self._situation.person and p.group is None]
        if alone and len(everybody) > 1:
            self._try(replace(self._best, people=(alone[0],)))
        self._remove(lambda t: t.people, lambda t, kept: replace(t, people=kept))

    def _machines(self) -> None:
        self._try(replace(self._best, agvs={}, yielding=frozenset()))
        for name in [*self._best.agvs]:
            self._try(replace(self._best, agvs=_without(self._best.agvs, name)))
        for name in [*self._best.agvs]:
            self._remove_moves(name)
        for name in [*self._best.machines]:
            fields = _without(self._best.fields, name)
            self._try_with(machines=_without(self._best.machines, name), fields=fields)

    def _jobs(self) -> None:
        gantry = self._best.gantry
        self._try(replace(self._best, gantry=replace(gantry, jobs=(), drops=(), repeat=False)))
        if gantry.repeat:
            self._try(replace(self._best, gantry=replace(self._best.gantry, repeat=False)))
        self._remove(
            lambda t: t.gantry.jobs, lambda t, kept: replace(t, gantry=replace(t.gantry, jobs=kept))
        )
        self._skip_ahead()

    def _skip_ahead(self) -> None:
        """Let the gantry start where it has done the first jobs, after a wait as long as they took.

        What breaks may need the instant at which a job begins, and not the jobs before it.
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
        """Leave out what happens in the trial otherwise."""
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
        self._remove(lambda t: t.blackouts, lambda t, kept: replace(t, blackouts=kept))
        self._remove(lambda t: t.obstacles, lambda t, kept: replace(t, obstacles=kept))
        self._remove(lambda t: t.commands, lambda t, kept: replace(t, commands=kept))
        for name in [*self._best.doors]:
            self._try(replace(self._best, doors=_without(self._best.doors, name)))

    def _keys_of_people(self) -> None:
        """Leave out keys of people: all but those that matter most, or else one by one."""
        for k, person in enumerate(self._best.people):
            plain = PersonEntry(name=person.name)
            kept = {key: getattr(person, key) for key in OF_A_PERSON}
            self._try(_with_person(self._best, k, replace(plain, **kept)))
            for key in vars(plain):
                changed = replace(self._best.people[k], **{key: getattr(plain, key)})
                self._try_with(people=_with_person(self._best, k, changed).people)

    def _keys_of_machines(self) -> None:
        """Leave out keys of machines, and entries of their lists, but for what is tested."""
        for name, entry in self._best.machines.items():
            for key in [key for key in entry.keys if key not in TESTED]:
                keys = self._best.machines[name].keys
                if self._try_with(machines=self._machines_with(name, _without(keys, key))):
                    continue
                if key in LISTS:
                    self._remove_from_list(name, key)

    def _remove_from_list(self, name: str, key: str) -> None:
        """Leave out entries of a list of a machine."""

        def having(trial: Trial, kept: Sequence[Any]) -> Trial:
            keys = {**trial.machines[name].keys, key: [*kept]}
            return replace(trial, machines=self._machines_with(name, keys))

        self._remove(lambda trial: trial.machines[name].keys[key], having)

    def _machines_with(self, name: str, keys: Mapping[str, Any]) -> dict[str, MachineEntry]:
        machines = self._best.machines
        return {**machines, name: replace(machines[name], keys=dict(keys))}

    def _others(self) -> None:
        """Leave out the other keys of the trial and of the gantry."""
        for name in ("work", "sources"):
            self._try_with(**{name: {}})
        self._try_with(workload=None)
        self._try_with(warm_up=0.0)
        self._try_with(planner=Scenario(self._best.floorplan).planner)
        self._try_with(gantry=replace(self._best.gantry, at=None))

    def _remove_moves(self, agv: str) -> None:
        self._remove(
            lambda trial: trial.agvs[agv],
            lambda trial, kept: replace(trial, agvs={**trial.agvs, agv: kept}),
        )

    def _remove(
        self,
        entries: Callable[[Trial], Sequence[_Entry]],
        having: Callable[[Trial, tuple[_Entry, ...]], Trial],
    ) -> None:
        """Leave out as many entries as can be: halves first, then quarters, then one by one."""
        size = max(len(entries(self._best)) // 2, 1)
        while size and entries(self._best):
            k = 0
            while k < len(entries(self._best)):
                kept = entries(self._best)
                if not self._try(having(self._best, (*kept[:k], *kept[k + size :]))):
                    k += size
            size //= 2

    def _round(self, digits: int) -> None:
        """Round every number to so many decimals: all together, or else one by one."""
        count = len([*_numbers(self._best, self._paths)])
        together = self._best
        for k in range(count):
            together = _rounded(together, self._paths, k, digits) or together
        if self._try(together):
            return
        for k in range(count):
            self._try(_rounded(self._best, self._paths, k, digits))


def _without(entries: Mapping[str, _Entry], name: str) -> dict[str, _Entry]:
    return {other: entry for other, entry in entries.items() if other != name}


def _with_person(trial: Trial, k: int, person: PersonEntry) -> Trial:
    return replace(trial, people=(*trial.people[:k], person, *trial.people[k + 1 :]))


Put = Callable[[Trial, float], Trial]
"""Puts a number into a trial."""


def _rounded(trial: Trial, paths: Sequence[str], k: int, digits: int) -> Candidate:
    """Return the trial with the number `k` rounded; None if it is, or can't be there."""
    number, put = [*_numbers(trial, paths)][k]
    if round(number, digits) == number:
        return None
    try:
        return put(trial, float(round(number, digits)) + 0.0)  # no negative zero
    except (UserError, ValueError):
        return None


def _numbers(trial: Trial, paths: Sequence[str]) -> Iterator[tuple[float, Put]]:
    """Yield the numbers of a trial that may be round, and what puts another in their place."""
    for k, person in enumerate(trial.people):
        yield from _of_person(k, person)
    at = trial.gantry.at
    for axis in range(3 if at is not None else 0):
        assert at is not None
        yield at[axis], _gantry_at(axis)
    for k, job in enumerate(trial.gantry.jobs):
        if job.kind == "wait":
            yield job.seconds, _job_seconds(k)
    for name, moves in trial.agvs.items():
        for k, move in enumerate(moves):
            yield move.time, _move_time(name, k)
    for path in paths:
        number = _at_path(trial, path)
        if number is not None:
            yield number, _path(path)


def _of_person(k: int, person: PersonEntry) -> Iterator[tuple[float, Put]]:
    def put(trial: Trial, **changed: Any) -> Trial:
        return _with_person(trial, k, replace(trial.people[k], **changed))

    if person.start.time is not None:
        yield person.start.time, lambda trial, x: put(trial, start=Start(time=x))
    if is_number(person.max_speed):
        speed: Any = person.max_speed
        yield speed, lambda trial, x: put(trial, max_speed=x)
    if isinstance(person.at, tuple):
        yield person.at[0], lambda trial, x: put(trial, at=(x, _place(trial.people[k])[1]))
        yield person.at[1], lambda trial, y: put(trial, at=(_place(trial.people[k])[0], y))


def _place(person: PersonEntry) -> Point:
    assert isinstance(person.at, tuple)  # as it is when a number of it varies
    return person.at


def _gantry_at(axis: int) -> Put:
    def put(trial: Trial, number: float) -> Trial:
        at = [*(trial.gantry.at or ())]
        at[axis] = number
        return replace(trial, gantry=replace(trial.gantry, at=(at[0], at[1], at[2])))

    return put


def _job_seconds(k: int) -> Put:
    def put(trial: Trial, number: float) -> Trial:
        jobs = trial.gantry.jobs
        changed = (*jobs[:k], replace(jobs[k], seconds=number), *jobs[k + 1 :])
        return replace(trial, gantry=replace(trial.gantry, jobs=changed))

    return put


def _move_time(name: str, k: int) -> Put:
    def put(trial: Trial, number: float) -> Trial:
        moves = trial.agvs[name]
        changed = (*moves[:k], replace(moves[k], time=number), *moves[k + 1 :])
        return replace(trial, agvs={**trial.agvs, name: changed})

    return put


def _path(path: str) -> Put:
    return lambda trial, number: put_at(trial, path, number)


def _at_path(trial: Trial, path: str) -> float | None:
    """Return the number at a path as of a study; None where it leads to none or to several."""
    found: Any = trial
    for part in path.split("."):
        if isinstance(found, tuple):
            found = next((one for one in found if getattr(one, "name", "") == part), None)
        elif isinstance(found, dict):
            found = found.get(part)
        else:
            found = getattr(found, part, None)
    return float(found) if is_number(found) else None
