"""The figures of a run for people to read, on a terminal or in a notebook."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any


def figures_in_words(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The figures of a summary that people look at first: what it is, and how much."""
    figures = [
        ("violations", _violations(summary)),
        ("penalties", str(summary["penalties"])),
        ("violations with AGVs", str(summary.get("agv_violations", summary["agv_teleports"]))),
        ("teleports by AGVs", str(summary["agv_teleports"])),
        ("gantry disabled", f"{summary['gantry_disabled_time']:.1f} s"),
        ("gantry jobs done", str(summary["jobs_done"])),
    ]
    if summary.get("protective_stops"):
        stood = f"{summary['protective_stops']}, {summary['protective_stop_time']:.1f} s"
        figures.append(("protective stops", stood))
    if "orders" in summary:
        figures.append(("score", f"{summary['score']} of {summary['best_score']}"))
        figures += [(f"order {name}", _order(order)) for name, order in summary["orders"].items()]
    nearest = summary["minimum_separation"]
    if nearest is not None:
        figures.append(
            (
                "nearest to the gantry",
                f"{nearest['distance']:.2f} m at {nearest['time']:.1f} s"
                f" ({nearest['required']:.2f} m required)",
            )
        )
    if summary.get("law_audit"):
        figures.append(("stops longer than the law's", _short(summary["law_audit"])))
    for name, person in summary["people"].items():
        figures += [
            (f"{name}: personality", Path(person["personality"]).stem),
            (f"{name}: visits", _counted(person["visits"])),
            (f"{name}: walked", f"{person['distance_walked']:.1f} m"),
            (f"{name}: stood", f"{person['time_standing']:.1f} s"),
            (f"{name}: replans", str(person["replans"])),
        ]
    return figures


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
