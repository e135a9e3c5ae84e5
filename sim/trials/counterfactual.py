"""Counterfactual of a trial: the same trial without machines, or without people."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from floorplan import Problem, UserError

from ..core.entries import Start
from ..core.scenario import GantryEntry, PersonEntry, TrialError
from .trial import Trial

OF_PEOPLE = ("visits", "distance_walked", "time_standing")
"""Figures of people that are compared with a run without machines."""

OF_MACHINES = ("jobs_done", "gantry_idle_time", "gantry_disabled_time", "protective_stop_time")
"""Figures of machines that are compared with a run without people."""

WITHOUT_MACHINES = "without machines"
"""Value of the key `counterfactual`."""


def counterfactual_of(trial: Trial, started: Mapping[str, float | None]) -> Trial:
    """Return the counterfactual of a trial, with the same draws.

    People start when they `started` (s), because the events that they waited for may not occur.
    """
    bare = replace(trial, counterfactual=None, expect={}, workload=None, until_submitted=False)
    if trial.counterfactual != WITHOUT_MACHINES:
        return replace(bare, workload=trial.workload, people=(), work={})
    plan = replace(trial.floorplan, gantry=None, lanes=())
    return replace(
        bare,
        floorplan=plan,
        floorplan_source="",
        people=tuple(_started(one, started.get(one.name), trial.duration) for one in trial.people),
        gantry=GantryEntry(),
        agvs={},
        yielding=frozenset(),
        machines={},
        fields={},
        blackouts=(),
        commands=tuple(one for one in trial.commands if not (one.hold or one.release or one.call)),
    )


def _started(person: PersonEntry, began: float | None, duration: float) -> PersonEntry:
    if person.start.time is not None:
        return person
    return replace(person, start=Start(time=duration if began is None else began))


def difference(
    trial: Trial, summary: Mapping[str, Any], other: Mapping[str, Any]
) -> dict[str, Any]:
    """Return what a run has more than its counterfactual, from the summaries of both."""
    if trial.counterfactual != WITHOUT_MACHINES:
        return {key: summary[key] - other[key] for key in OF_MACHINES}
    people = {
        name: _more(figures, other["people"][name]) for name, figures in summary["people"].items()
    }
    return {key: sum(one[key] for one in people.values()) for key in OF_PEOPLE} | {"people": people}


def _more(figures: Mapping[str, Any], others: Mapping[str, Any]) -> dict[str, float]:
    return {key: _amount(figures[key]) - _amount(others[key]) for key in OF_PEOPLE}


def _amount(value: Any) -> float:
    return len(value) if isinstance(value, list) else value


def counterfactual_error(why: UserError) -> TrialError:
    """Return the error of a counterfactual that cannot be run."""
    return TrialError("counterfactual", [Problem(f"the trial cannot be run so: {why}")])
