"""The figures of a run that a trial can expect something of, by name."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ..core.recorder import Event
from ..core.scenario import Scenario
from ..record.figures import FIGURES, PEOPLE, SummaryFigure
from ..record.outcome import Outcome
from .names import machines, orders, people, zones


@dataclass(frozen=True)
class SummaryField:
    """A figure of a run of a trial: where it stands in the summary or the metrics, and of whom."""

    figure: SummaryFigure
    path: tuple[str, ...]
    name: str = ""

    def value(self, run: Outcome) -> Any:
        """Return what it is in `run`; None where there is no such figure."""
        value: Any = run.summary
        if self.path[0] == "metrics":
            value = {"metrics": run.metrics}
        for key in self.path:
            if not isinstance(value, dict):
                return None
            value = value.get(key)
        return value

    def instants(self, run: Outcome) -> list[float]:
        """Return when the things happened that it counts, seconds."""
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
        found = [e for e in run.events if e["kind"] == kind.kind and _match(e, fields)]
        if self.figure.form == "visits":
            found = [e for e in found if e["station"] is not None]
        return [e["t"] for e in found]


def _match(event: Event, fields: Mapping[str, Container[Any]]) -> bool:
    """Return whether an event has these fields, each with one of its values."""
    return all(event.get(key) in values for key, values in fields.items())


def summary_fields(trial: Scenario) -> dict[str, SummaryField]:
    """Return all figures of the runs of `trial`, by the names that expectations call them.

    A person's are also found without `people.NAME.` where the trial has one person.
    """
    found: dict[str, SummaryField] = {}
    alone: dict[str, SummaryField] = {}
    for figure in FIGURES.values():
        if figure.form in ("text", "parts") or not figure.only(trial) or figure.null(trial):
            continue
        for path, name in _paths(figure.path, trial):
            field = SummaryField(figure, path, name)
            keys = [".".join(path)] + ([".".join(path[:-1])] if figure.short else [])
            found |= dict.fromkeys(keys, field)
            if figure.path.startswith(PEOPLE):
                alone |= {key.removeprefix(f"people.{name}."): field for key in keys}
    return (alone | found) if len(trial.people) == 1 else found


def machine_field(key: str, trial: Scenario) -> SummaryField | None:
    """Return the figure `machines.NAME.FIGURE`, if `trial` has a machine of that name to add.

    Which figures a machine has is up to its kind.
    """
    path = tuple(key.split("."))
    if len(path) != 3 or path[0] != "machines" or path[1] not in trial.machines:
        return None
    return SummaryField(SummaryFigure(path=key), path, path[1])


def _paths(path: str, trial: Scenario) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield each path that `path` stands for, with the name in it."""
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
