"""The figures of a run that a trial can expect something of: their names, and what they are."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from ..core.scenario import Scenario
from ..orders import Workload
from ..record.outcome import Outcome
from ..record.social_metrics import DISTANCES, MOVEMENT, PROGRESS
from .names import machines, people

Form = Literal["number", "visits", "flag"]

_FIGURES = (
    "duration",
    "penalties",
    "agv_violations",
    "agv_teleports",
    "protective_stops",
    "protective_stop_time",
    "gantry_disabled_time",
    "gantry_idle_time",
    "jobs_done",
)
_PERSON_FIGURES = ("started", "distance_walked", "time_standing", "replans")
_SEPARATION = ("distance", "time", "required")
_CAUSES = ("gantry", "person")


@dataclass(frozen=True)
class SummaryField:
    """A figure of a run: where it stands in the summary or the metrics, and what it is.

    `events` tells which events made it what it is: a kind, and fields that they have.
    """

    path: tuple[str, ...]
    form: Form = "number"
    events: tuple[str, tuple[tuple[str, Any], ...]] | None = None

    def value(self, run: Outcome) -> Any:
        """What it is in `run`; None where there is no such figure."""
        value: Any = run.summary
        if self.path[0] == "metrics":
            value = {"metrics": run.metrics}
        for key in self.path:
            if not isinstance(value, dict):
                return None
            value = value.get(key)
        return value

    def instants(self, run: Outcome) -> list[float]:
        """When the things happened that it counts, seconds."""
        if self.events is None:
            if self.path[-2:-1] == ("minimum_separation",):
                time = SummaryField((*self.path[:-1], "time")).value(run)
                return [] if time is None else [time]
            return []
        kind, fields = self.events
        found = [e for e in run.events if e["kind"] == kind and fields_match(e, dict(fields))]
        if self.form == "visits":
            found = [e for e in found if e["station"] is not None]
        return [e["t"] for e in found]


def fields_match(event: dict[str, Any], fields: dict[str, Any]) -> bool:
    """Whether an event has these fields with these values."""
    return all(event.get(key) == value for key, value in fields.items())


def summary_fields(trial: Scenario) -> dict[str, SummaryField]:
    """All figures of the runs of `trial`, by the names that expectations call them.

    A person's are also found without `people.NAME.` where the trial has one person.
    """
    names = people(trial)
    fields = {key: SummaryField((key,), events=_EVENTS.get(key)) for key in _FIGURES}
    fields |= _violations((), ())
    fields["interrupted"] = SummaryField(("interrupted",), "flag")
    for prefix in [(), *(("people", name) for name in names)]:
        fields |= _separation(prefix)
    if trial.workload is not None:
        fields |= _work(trial.workload)
    for name in names:
        person = dict(_person(name))
        fields |= {f"people.{name}.{key}": field for key, field in person.items()}
        if len(names) == 1:
            fields = person | fields
    return fields | {
        ".".join(path): SummaryField(path) for path in _metrics(names, machines(trial))
    }


_Fields = dict[str, SummaryField]

_EVENTS: dict[str, tuple[str, tuple[tuple[str, Any], ...]]] = {
    "penalties": ("violation", (("penalty", True),)),
    "agv_violations": ("violation", (("cause", "agv"),)),
    "agv_teleports": ("teleport", (("reason", "agv"),)),
    "protective_stops": ("protective_stop", ()),
    "protective_stop_time": ("protective_stop", ()),
    "gantry_disabled_time": ("gantry_disabled", ()),
    "jobs_done": ("job_done", ()),
}


def _work(workload: Workload) -> _Fields:
    """The points for orders, and how long each took."""
    fields = {key: SummaryField((key,)) for key in ("score", "best_score")}
    for order in workload.orders:
        submitted = ("order_submitted", (("order", order.id),))
        for figure in ("announced", "submitted", "time", "score"):
            path = ("orders", order.id, figure)
            fields[".".join(path)] = SummaryField(path, events=submitted)
    return fields


def _separation(prefix: tuple[str, ...]) -> dict[str, SummaryField]:
    """The least separation, which is a distance by its bare name."""
    key = ".".join((*prefix, "minimum_separation"))
    path = (*prefix, "minimum_separation")
    parts = {f"{key}.{part}": SummaryField((*path, part)) for part in _SEPARATION}
    return {key: SummaryField((*path, "distance")), **parts}


def _violations(path: tuple[str, ...], fields: tuple[tuple[str, Any], ...]) -> _Fields:
    """Return the violations with the gantry by their cause, by their names inside `path`."""
    return {
        f"violations.{cause}": SummaryField(
            (*path, "violations", cause), events=("violation", (*fields, ("cause", cause)))
        )
        for cause in _CAUSES
    }


def _person(name: str) -> Iterator[tuple[str, SummaryField]]:
    path = ("people", name)
    yield from _violations(path, (("person", name),)).items()
    for key in _PERSON_FIGURES:
        events = ("replanned", (("person", name),)) if key == "replans" else None
        yield key, SummaryField((*path, key), events=events)
    arrivals = ("arrived", (("person", name),))
    yield "visits", SummaryField((*path, "visits"), "visits", arrivals)


def _metrics(people: list[str], machines: list[str]) -> Iterator[tuple[str, ...]]:
    for name in people:
        person = ("metrics", "people", name)
        yield from ((*person, key) for key in (*MOVEMENT, *PROGRESS))
        others = [other for other in (*people, *machines) if other != name]
        yield from ((*person, "distance_to", other, key) for other in others for key in DISTANCES)
    for name in machines:
        machine = ("metrics", "machines", name)
        yield from ((*machine, key) for key in MOVEMENT)
        yield from ((*machine, "distance_to_people", key) for key in DISTANCES)
