"""Objective of a search: a figure, or the slack of an expectation, and when a trial breaks it."""

from __future__ import annotations

from dataclasses import KW_ONLY, replace
from typing import Any

from floorplan import InputError, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.problems import suggestion

from ..core.custom_code import is_ours
from ..core.entries import is_number
from ..core.scenario import Scenario
from ..record.outcome import Outcome
from ..runs.run import Run
from ..trials.expectations import SummaryField, machine_field, summary_fields
from ..trials.timeline import Verdict
from ..trials.trial import Trial


class ObjectiveError(UserError):
    """Error of an objective that trials do not have, or that is no number."""


@dataclass(frozen=True)
class Situation:
    """Person, machine, time and place of the worst moment of a run.

    `error` is the error of a trial that failed. Unknown values are empty.
    """

    person: str = ""
    machine: str = ""
    time: float | None = None
    x: float | None = None
    y: float | None = None
    error: str = ""


@dataclass(frozen=True)
class Objective:
    """Objective of a search: the figure to `minimise`, or the `slack` of that name.

    A trial breaks it with a value less than `below`, or with an error.
    """

    minimise: str = ""
    _: KW_ONLY
    slack: str = ""
    below: float = 0.0

    def __post_init__(self) -> None:
        if bool(self.minimise) == bool(self.slack):
            raise ObjectiveError("a search needs one objective: minimise or slack")
        if not is_number(self.below):
            raise ObjectiveError(f"below must be a number, not {self.below!r}")
        if self.slack and self.below != 0.0:
            raise ObjectiveError("a slack breaks below 0: below belongs to minimise")

    def __str__(self) -> str:
        return self.minimise or f"slack of {self.slack}"

    def check(self, trial: Scenario) -> None:
        """Raise `ObjectiveError` if runs of `trial` do not have the objective."""
        if self.slack:
            expected = _expected(trial)
            if self.slack not in expected:
                hint = suggestion(self.slack, expected) if expected else "it expects nothing"
                raise ObjectiveError(
                    f"the trial {trial.name!r} expects nothing of {self.slack!r}; {hint}"
                )
            return
        fields = summary_fields(trial)
        known_field = self._field(trial)
        if known_field is None:
            alike = [name for name in fields if name.count(".") == self.minimise.count(".")]
            hint = suggestion(self.minimise, alike or fields)
            message = f"a run of {trial.name!r} has no figure {self.minimise!r}; {hint}"
            raise ObjectiveError(message)
        if known_field.figure.form == "visits":
            raise ObjectiveError(f"{self.minimise} is a list of visits, not a number")

    def value(self, run: Run) -> float | None:
        """Return the value of the objective in a run, or None if the run does not have it."""
        if self.slack:
            return self._verdict(run).slack
        field = self._field(run.trial)
        amount = None if field is None else field.value(run)
        if amount is None:
            return None
        if not isinstance(amount, int | float):
            raise ObjectiveError(f"{self.minimise} is {amount!r}, not a number")
        return float(amount)

    def is_broken_by(self, value: float | None) -> bool:
        """Return True if a run with this value breaks the objective."""
        return value is not None and value < self.below

    def situation(self, run: Run) -> Situation:
        """Return the situation in which a run is worst, according to its figures and events."""
        if self.slack:
            verdict = self._verdict(run)
            field = summary_fields(run.trial).get(self.slack)
            time = verdict.time
        else:
            field = self._field(run.trial)
            instants = [] if field is None else field.instants(run)
            time = instants[-1] if instants else None
        beside = _beside(field, run)
        person, machine = str(beside.get("person", "")), str(beside.get("machine", ""))
        if time is not None and not person:
            events = [event for event in run.events if event["t"] == time]
            person = next((str(e["person"]) for e in events if "person" in e), "")
            machine = next((str(e["with"]) for e in events if "with" in e), "")
        if time is None or person not in run.motions:
            return Situation(person, machine, time)
        x, y = run.motions[person].state_before(time).at
        return Situation(person, machine, time, round(x, 3), round(y, 3))

    def instants(self, run: Run) -> list[float]:
        """Return the times (s) of the events that break the objective, as far as they are known.

        For a figure to minimise, this is the time of its value. For an expectation, for example of
        a count, these are the times of all counted events.
        """
        field = summary_fields(run.trial).get(self.slack) if self.slack else self._field(run.trial)
        times = [] if field is None else field.instants(run)
        if not self.slack:
            return times[-1:]
        time = self._verdict(run).time
        return times or ([] if time is None else [time])

    def expected(self, trial: Trial) -> Trial:
        """Return `trial` with this objective as its only expectation, so that it fails."""
        if self.minimise:
            return replace(trial, expect={self.minimise: f">= {self.below:g}"})
        key, _, number = self.slack.partition(".")
        wanted = trial.expect.get(self.slack)
        if wanted is None and key in trial.expect:
            return replace(trial, expect={key: [trial.expect[key][int(number)]]})
        return replace(trial, expect={self.slack: wanted})

    def of_expected(self) -> Objective:
        """Return the objective in the trial that `expected` returns."""
        key, _, number = self.slack.partition(".")
        return replace(self, slack=f"{key}.0") if key == "timeline" and number else self

    def _field(self, trial: Scenario) -> SummaryField | None:
        return summary_fields(trial).get(self.minimise) or machine_field(self.minimise, trial)

    def _verdict(self, run: Run) -> Verdict:
        return next(one for one in run.verdicts if _key(one.place) == self.slack)


def _key(place: tuple[str | int, ...]) -> str:
    return ".".join(map(str, place))


def _expected(trial: Scenario) -> list[str]:
    """Return the names of the expectations of a trial. Those over time have numbers."""
    names = [key for key in trial.expect if key != "timeline"]
    return names + [f"timeline.{k}" for k, _ in enumerate(trial.expect.get("timeline", ()))]


def _beside(field: SummaryField | None, run: Outcome) -> dict[str, Any]:
    """Return the figures beside one, such as the person of a margin."""
    if field is None or len(field.path) < 2:
        return {}
    above = replace(field, path=field.path[:-1]).value(run)
    return above if isinstance(above, dict) else {}


def makes_no_trial(why: Exception) -> bool:
    """Return True if an error means that values make no trial, not that a run failed."""
    return isinstance(why, InputError | OSError | ObjectiveError)


def failure_in_words(why: Exception) -> str:
    """Return an error on one line, with its type unless it is Floorwalker's."""
    words = str(why) if is_ours(why) else f"{type(why).__name__}: {why}"
    return " ".join(words.split())
