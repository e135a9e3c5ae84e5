"""Findings of safety reports: stops by cause, counts after the warm-up, sign-off."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ..core.entries import SignOff
from ..core.wording import figure, minus, percent
from ..record.incidents import Incident
from ..record.outcome import Outcome
from ..record.stops import CAUSES_OF_STOPS, MachineTimes
from ..record.warm_up import contacts_of

MOST_STOPS = 20
"""Maximum number of lines of the table of stops by person."""

SHORTEST = 0.05
"""Seconds. Causes that are shorter for every machine are omitted, because they show as 0.0."""

SIGNED_BY = ("prepared", "checked", "approved")
"""Lines to sign."""


def stops_in_tables(times: Sequence[MachineTimes], runs: int = 1) -> dict[str, Any]:
    """Return the tables of stops by cause and by person, as means per run of `runs`."""
    longest = {
        c: max((one.stopped.get(c, 0.0) for one in times), default=0.0) for c in CAUSES_OF_STOPS
    }
    causes = [cause for cause, seconds in longest.items() if seconds / runs >= SHORTEST]
    rows = [
        (
            one.machine,
            figure(one.moving / runs, 1),
            *(_seconds(one, cause, runs) for cause in causes),
            figure(one.jobs_done / runs) if one.had_jobs else "–",
        )
        for one in times
    ]
    whom = [
        (one.machine, cause, who, figure(count / runs), figure(seconds / runs, 1), seconds)
        for one in times
        for (cause, who), (count, seconds) in one.whom.items()
    ]
    whom.sort(key=lambda row: -float(row[-1]))
    return {
        "heads": ("machine", "moving", *causes, "jobs done"),
        "rows": rows,
        "whom": [row[:-1] for row in whom[:MOST_STOPS]],
        "whom_count": len(whom),
        "meanings": [(cause, CAUSES_OF_STOPS[cause]) for cause in causes],
    }


def _seconds(one: MachineTimes, cause: str, runs: int) -> str:
    if cause not in one.stopped:
        return "–"
    whole = one.moving + sum(one.stopped.values())
    seconds = one.stopped[cause]
    return f"{figure(seconds / runs, 1)} ({percent(seconds, whole)})"


def without_a_job(times: Sequence[MachineTimes], people: int) -> list[str]:
    """Return the robots that had jobs beside people and finished none."""
    return [one.machine for one in times if people and one.had_jobs and not one.jobs_done]


def counts(
    run: Outcome, violations: Sequence[Incident], times: Sequence[MachineTimes]
) -> list[str]:
    """Return the numbers of the events in `COUNTED`."""
    robots = {one.name for one in run.scene.machines if one.category == "robot"}
    with_robots = sum(one.machine in robots for one in violations)
    amounts = (
        with_robots,
        len(violations) - with_robots,
        contacts_of(run),
        contacts_of(run, "with"),
        sum(event["kind"] == "penalty" or event.get("penalty") is True for event in run.events),
        sum(event["kind"] == "teleport" for event in run.events),
        sum(one.jobs_done for one in times),
    )
    least = min((one.margin for one in violations), default=None)
    return [*map(str, amounts), "–" if least is None else minus(f"{least:.3f} m")]


COUNTED = (
    "violations with robots",
    "violations with vehicles that move",
    "contacts with machines",
    "contacts with the floor",
    "penalties",
    "people taken to the safe zone",
    "jobs done",
    "least margin of the violations",
)
"""Names of the values of `counts`."""

CATEGORIES = ("robot", "vehicle")
"""Categories of machines of the first counts."""


def sign_off_rows(sign_off: SignOff) -> Iterator[tuple[str, str]]:
    """Yield the entries of the sign-off block. Missing entries are empty."""
    for key in ("plant", "revision", "author", "date"):
        yield key, getattr(sign_off, key)
