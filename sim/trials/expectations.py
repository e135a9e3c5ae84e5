"""Expectations of a run: values of the summary, visits, and their verdicts.

`docs/testing.md` describes how they are written.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import replace
from difflib import SequenceMatcher
from typing import Any

from floorplan import UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.problems import Place, suggestion

from ..core.entries import is_number
from ..core.recorder import Event
from ..core.scenario import Scenario
from ..core.wording import times
from ..record.figures import FIGURES, PEOPLE, SummaryFigure
from ..record.outcome import Outcome
from . import names, slack
from .names import machines, orders, people, zones
from .slack import NOTHING
from .timeline import NumberCondition, Verdict, in_words, read_statement


@dataclass(frozen=True)
class SummaryField:
    """Figure of a run: its place in the summary or the metrics, and its person or machine."""

    figure: SummaryFigure
    path: tuple[str, ...]
    name: str = ""

    def value(self, run: Outcome) -> Any:
        """Return its value in `run`, or None if the run has no such figure."""
        value: Any = {"metrics": run.metrics} if self.path[0] == "metrics" else run.summary
        for key in self.path:
            if not isinstance(value, Mapping) or key not in value:
                return None
            value = value[key]
        return value

    def instants(self, run: Outcome) -> list[float]:
        """Return the times (s) of the events that it counts."""
        if self.figure.instant:
            beside = SummaryField(self.figure, (*self.path[:-1], self.figure.instant))
            time = beside.value(run)
            return [] if time is None else [time]
        if self.figure.events is None:
            return []
        kind, named = self.figure.events
        vehicles = {one.kind for one in run.scene.machines if one.category == "vehicle"}
        meant = {"NAME": {self.name}, "VEHICLE": vehicles}
        fields = {key: meant.get(value, {value}) for key, value in named.items()}
        events = [e for e in run.events if e["kind"] == kind.kind and _match(e, fields)]
        if self.figure.form == "visits":
            events = [e for e in events if e["station"] is not None]
        return [e["t"] for e in events]


def _match(event: Event, fields: Mapping[str, Container[Any]]) -> bool:
    """Return whether each of these fields of an event has one of the values."""
    return all(event.get(key) in values for key, values in fields.items())


def summary_fields(trial: Scenario) -> dict[str, SummaryField]:
    """Return all figures of the runs of `trial`, by their names in expectations.

    If the trial has one person, their figures also have names without `people.NAME.`.
    """
    fields: dict[str, SummaryField] = {}
    alone: dict[str, SummaryField] = {}
    for figure in FIGURES.values():
        if figure.form in ("text", "parts") or not figure.only(trial) or figure.null(trial):
            continue
        for path, name in _paths(figure.path, trial):
            field = SummaryField(figure, path, name)
            keys = [".".join(path)] + ([".".join(path[:-1])] if figure.short else [])
            fields |= dict.fromkeys(keys, field)
            if figure.path.startswith(PEOPLE):
                alone |= {key.removeprefix(f"people.{name}."): field for key in keys}
    return (alone | fields) if len(trial.people) == 1 else fields


def machine_field(key: str, trial: Scenario) -> SummaryField | None:
    """Return the figure `machines.NAME.FIGURE` of a machine that is added or has fields.

    Which figures a machine has is up to its kind.
    """
    path = tuple(key.split("."))
    if len(path) != 3 or path[0] != "machines" or path[1] not in {*trial.machines, *trial.fields}:
        return None
    return SummaryField(SummaryFigure(path=key), path, path[1])


def _paths(path: str, trial: Scenario) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield each path that matches `path`, with the name in it."""
    above, named, below = path.partition(".NAME")
    if not named:
        yield tuple(path.split(".")), ""
        return
    group = above.split(".")
    named_in = {"people": people, "machines": machines, "orders": orders, "zones": zones}
    everybody = named_in[group[-1]](trial)
    for name in everybody:
        rest = below.split(".")[1:]
        others = [*people(trial), *machines(trial)] if "OTHER" in rest else [name]
        for other in others:
            if other != name or "OTHER" not in rest:
                yield (*group, name, *(other if key == "OTHER" else key for key in rest)), name


TIMELINE = "timeline"
"""Key of expectations over time."""

_VISITS = {
    "begin_with": "to begin with",
    "in_order": "to have in this order",
    "exactly": "to be exactly",
    "never": "never to have",
}

Check = Callable[["Outcome"], Verdict]


def expectation_problems(trial: Scenario) -> Iterator[tuple[str, Place]]:
    """Yield the faults of the expectations of `trial`."""
    for place, check in _checks(trial):
        if isinstance(check, ValueError):
            yield str(check), place


def verdicts(trial: Scenario, run: Outcome) -> list[Verdict]:
    """Return a verdict on each expectation of `trial`. `UserError` if one cannot be checked."""
    results = []
    for place, check in _checks(trial):
        if isinstance(check, ValueError):
            raise check
        results.append(replace(check(run), place=place))
    return results


def _checks(trial: Scenario) -> Iterator[tuple[Place, Check | ValueError]]:
    """Return each expectation as a check, or what is wrong with it."""
    fields = summary_fields(trial) if trial.expect else {}
    for key, expected in trial.expect.items():
        if key != TIMELINE:
            yield (key,), _attempt(_field_check, key, expected, fields, trial)
        elif not isinstance(expected, list):
            yield (key,), UserError(f"expected a list, found {expected!r}")
        else:
            for k, written in enumerate(expected):
                yield (key, k), _attempt(_statement_check, written, trial)


def _attempt(read: Callable[..., Check], *arguments: Any) -> Check | ValueError:
    try:
        return read(*arguments)
    except UserError as why:
        return why


def _statement_check(written: Any, trial: Scenario) -> Check:
    return read_statement(written, trial).check


def _field_check(
    key: str, expected: Any, fields: Mapping[str, SummaryField], trial: Scenario
) -> Check:
    field = fields.get(key) or machine_field(key, trial)
    if field is None:
        group, _, rest = key.partition(".")
        if group == "machines" and rest:
            names.checked_name(rest.partition(".")[0], "machine", names.machines(trial))
        raise UserError(f"a run has no such figure; {_hint(key, fields)}")
    if field.figure.form == "visits":
        return _visits(key, expected, field, trial)
    if field.figure.form == "flag":
        if not isinstance(expected, bool):
            raise UserError(f"expected true or false, found {expected!r}")
        flag = in_words(expected)
        return _FigureCheck(key, field, flag, lambda value: slack.of_flag(value is expected))
    comparison = NumberCondition.parse(expected)
    return _FigureCheck(key, field, comparison.text, comparison.slack)


MOST_NEAR = 5
"""Maximum number of suggestions for an unknown figure."""


def _hint(key: str, fields: Mapping[str, SummaryField]) -> str:
    """Return the figures with the most similar names to `key`."""
    # One name is enough for a figure that each person has.
    kinds = {field.figure.path: name for name, field in reversed([*fields.items()])}
    names, last = [*kinds.values(), TIMELINE], key.rpartition(".")[2]

    def likeness(name: str) -> float:
        if name.endswith(f".{key}") or name.startswith(f"{key}."):
            return 2.0
        ratios = SequenceMatcher(None, key, name), SequenceMatcher(None, last, name.split(".")[-1])
        return max(ratio.ratio() for ratio in ratios)

    near = ", ".join(sorted(names, key=likeness, reverse=True)[:MOST_NEAR])
    return f"the nearest are {near} ('floorwalker list figures' lists all)"


@dataclass(frozen=True)
class _FigureCheck:
    """Expectation of a figure of the summary or the metrics."""

    key: str
    field: SummaryField
    expected: str
    slack: Callable[[Any], float]

    def __call__(self, run: Outcome) -> Verdict:
        value = self.field.value(run)
        if value is None:
            meaning = self.field.figure.meaning
            nothing = f"there is none ({meaning})" if meaning else self._unknown(run)
            return Verdict(f"{self.key} {self.expected}", found=nothing, met=False, slack=NOTHING)
        amount = self.slack(value)
        instants = self.field.instants(run)
        when = f" (t = {times(instants, 5)})" if instants else ""
        return Verdict(
            f"{self.key} {self.expected}",
            found=f"it is {in_words(value)}{when}",
            met=amount >= 0.0,
            slack=amount,
            unit=self.field.figure.unit,
            time=instants[-1] if instants else None,
        )

    def _unknown(self, run: Outcome) -> str:
        """Return the message about an unknown figure, with a suggestion."""
        *above, last = self.field.path
        beside = replace(self.field, path=tuple(above)).value(run)
        figures = [key for key, value in (beside or {}).items() if is_number(value)]
        hint = f"; {suggestion(last, figures)}" if figures else ""
        return f"there is no such figure{hint}"


def _visits(key: str, expected: Any, field: SummaryField, trial: Scenario) -> Check:
    """Return the check of the visits of a person."""
    if isinstance(expected, list):
        expected = {"begin_with": expected}
    if not (isinstance(expected, Mapping) and len(expected) == 1 and set(expected) <= set(_VISITS)):
        raise UserError(
            f"expected a list of stations, or one of {', '.join(_VISITS)} with one: {expected!r}"
        )
    ((how, stations),) = expected.items()
    if not (isinstance(stations, list) and all(isinstance(one, str) for one in stations)):
        raise UserError(f"expected a list of stations, found {stations!r}")
    station_names = names.stations(trial)
    checked = tuple(names.checked_name(name, "station", station_names) for name in stations)
    return _VisitsCheck(key, field, how, checked)


@dataclass(frozen=True)
class _VisitsCheck:
    """Expectation of visits to stations in an order, or of none."""

    key: str
    field: SummaryField
    how: str
    stations: tuple[str, ...]

    def __call__(self, run: Outcome) -> Verdict:
        visited = self.field.value(run)
        wrong = self._first_wrong(visited)
        instants = self.field.instants(run)
        time = instants[wrong] if wrong is not None and wrong < len(instants) else None
        when = (
            f" ({visited[wrong]} at t = {time:.3f} s)"
            if wrong is not None and time is not None
            else ""
        )
        expected = f"{self.key} {_VISITS[self.how]} {', '.join(self.stations)}"
        shown = ", ".join(visited) or "none"
        return Verdict(
            expected,
            found=f"they were {shown}{when}",
            met=wrong is None,
            slack=slack.of_visits(visited, self.stations, self.how),
            unit="visits",
            time=time,
        )

    def _first_wrong(self, visited: list[str]) -> int | None:
        """Return the index of the first wrong or missing visit."""
        if self.how == "never":
            return next((k for k, name in enumerate(visited) if name in self.stations), None)
        if self.how == "in_order":
            visits = iter(visited)
            complete = all(any(name == visit for visit in visits) for name in self.stations)
            return None if complete else len(visited)
        if self.how == "begin_with":
            visited = visited[: len(self.stations)]
        pairs = itertools.zip_longest(self.stations, visited)
        return next((k for k, (station, visit) in enumerate(pairs) if station != visit), None)
