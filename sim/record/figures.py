"""The figures of a run for people to read, on a terminal or in a notebook."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

_LACKING = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError)
"""So a figure ends whose fields the summary lacks, or has in another form."""


def figures_in_words(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the figures of a summary that people look at first: names, and how much each is.

    Those are left out that a summary lacks because it was recorded by another version, or changed.
    """
    found: list[tuple[str, str]] = []
    for name, words in _figures(summary):
        with suppress(*_LACKING):
            found.append((name, words()))
    return found


def _figures(summary: Mapping[str, Any]) -> Iterator[tuple[str, Callable[[], str]]]:
    """Yield the name of each figure, and a function that puts it into words."""
    nearest, stopped = (summary.get(key) for key in ("minimum_separation", "protective_stops"))
    yield "violations with the gantry", lambda: _violations(summary)
    yield "penalties", lambda: str(summary["penalties"])
    yield "violations with AGVs", lambda: str(summary["agv_violations"])
    yield "teleports by AGVs", lambda: str(summary["agv_teleports"])
    yield "gantry disabled", lambda: f"{summary['gantry_disabled_time']:.1f} s"
    yield "gantry jobs done", lambda: str(summary["jobs_done"])
    if stopped:
        yield "protective stops", lambda: f"{stopped}, {summary['protective_stop_time']:.1f} s"
    if "orders" in summary:
        yield "score", lambda: f"{summary['score']} of {summary['best_score']}"
        for name, order in _named(summary, "orders"):
            yield f"order {name}", partial(_order, order)
    if nearest is not None:
        yield (
            "nearest to the gantry",
            lambda: (
                f"{nearest['distance']:.2f} m at {nearest['time']:.1f} s"
                f" ({nearest['required']:.2f} m required)"
            ),
        )
    if summary.get("law_audit"):
        yield "law assumes shorter stops of", lambda: _short(summary["law_audit"])
    for name, person in _named(summary, "people"):
        for figure, words in _PERSON_FIGURES.items():
            yield f"{name}: {figure}", partial(words, person)


def _named(summary: Mapping[str, Any], key: str) -> Iterable[tuple[str, Any]]:
    """Return the orders or the people of a summary by their names."""
    found = summary.get(key)
    return found.items() if isinstance(found, Mapping) else ()


def _violations(summary: Mapping[str, Any]) -> str:
    """Return how many there were with the gantry, and by which cause."""
    counts = {cause: count for cause, count in summary["violations"].items() if count}
    causes = [f"{cause} {count}×" for cause, count in counts.items()]
    return f"{sum(counts.values())}" + (f" ({', '.join(causes)})" if causes else "")


def _short(found: Sequence[Mapping[str, Any]]) -> str:
    """The machines that may take longer to stop than their law counts on."""
    agvs = sum(short["law"] == "agv_law" for short in found)
    names = [short["machine"] for short in found if short["law"] != "agv_law"]
    return ", ".join([*names, *([f"{agvs} AGV{'s' * (agvs > 1)}"] if agvs else [])])


def _order(order: Mapping[str, Any]) -> str:
    """What became of an order."""
    if order["submitted"] is None:
        outcome = "not announced" if order["announced"] is None else "not submitted"
    else:
        outcome = f"{order['score']} of {order['best']}, after {order['time']:.1f} s"
    missing = f" (without {', '.join(order['missing'])})" if order["missing"] else ""
    return f"{order['type']}: {outcome}{missing}"


def _counted(visits: list[str]) -> str:
    """How often each station was visited, in the order of the first visits."""
    counts = Counter(visits)
    return ", ".join(f"{name} {count}×" for name, count in counts.items()) or "none"


_PERSON_FIGURES: dict[str, Callable[[Any], str]] = {
    "personality": lambda person: Path(person["personality"]).stem,
    "visits": lambda person: _counted(person["visits"]),
    "walked": lambda person: f"{person['distance_walked']:.1f} m",
    "stood": lambda person: f"{person['time_standing']:.1f} s",
    "replans": lambda person: str(person["replans"]),
}
