"""Figures of a run in words, for terminals and notebooks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..core.wording import distinguished, to_millimetres

Words = Callable[[Any, Mapping[str, Any]], str]
"""Formats a figure from its value and the figures beside it, or returns "" if it is not shown."""


def plain(value: Any, beside: Mapping[str, Any]) -> str:
    """Return a number or a text unchanged."""
    return str(value)


def some(value: Any, beside: Mapping[str, Any]) -> str:
    """Return a number, or "" if it is 0."""
    return str(value) if value else ""


def seconds(value: Any, beside: Mapping[str, Any]) -> str:
    """Return a time."""
    return f"{value:.1f} s"


def metres(value: Any, beside: Mapping[str, Any]) -> str:
    """Return a length."""
    return f"{value:.1f} m"


def by_cause(value: Any, beside: Mapping[str, Any]) -> str:
    """Return the number of violations by cause."""
    counts = {cause: count for cause, count in value.items() if count}
    causes = [f"{cause} {count}×" for cause, count in counts.items()]
    return f"{sum(counts.values())}" + (f" ({', '.join(causes)})" if causes else "")


def stops(value: Any, beside: Mapping[str, Any]) -> str:
    """Return the number of protective stops and their duration."""
    return f"{value}, {beside['protective_stop_time']:.1f} s" if value else ""


def beside_robots(inner: Words) -> Words:
    """Return words for a figure that is shown only if there are people and gantries."""

    def put(value: Any, beside: Mapping[str, Any]) -> str:
        counts = value.values() if isinstance(value, Mapping) else [value]
        there = beside["minimum_separation"] is not None
        return inner(value, beside) if there or any(counts) else ""

    return put


def beside_vehicles(value: Any, beside: Mapping[str, Any]) -> str:
    """Return a number that is shown only if there are people and moving vehicles."""
    there = "nearest_agv" in beside and beside["people"]
    return str(value) if there or value else ""


def jobs(value: Any, beside: Mapping[str, Any]) -> str:
    """Return the number of jobs, or "" if there were people but no gantry and no job."""
    there = beside["minimum_separation"] is not None or not beside["people"]
    return str(value) if there or value else ""


def machine(value: Any, beside: Mapping[str, Any]) -> str:
    """Return the figures of an added machine, without times that are 0."""
    shown = []
    for key, number in value.items():
        if isinstance(number, bool) or not isinstance(number, int | float):
            continue
        label = key.replace("_", " ")
        if not key.endswith("_time"):
            shown.append(f"{label} {round(number, 2):g}")
        elif (words := seconds(number, value)) != "0.0 s":
            shown.append(f"{label} {words}")
    return ", ".join(shown)


def score(value: Any, beside: Mapping[str, Any]) -> str:
    """Return the points and the maximum points."""
    return f"{value} of {beside['best_score']}"


def order(value: Any, beside: Mapping[str, Any]) -> str:
    """Return the outcome of an order."""
    if value["submitted"] is None:
        outcome = "not announced" if value["announced"] is None else "not submitted"
    else:
        outcome = f"{value['score']} of {value['best']}, after {value['time']:.1f} s"
    missing = f" (without {', '.join(value['missing'])})" if value["missing"] else ""
    return f"{value['type']}: {outcome}{missing}"


def nearest_people(value: Any, beside: Mapping[str, Any]) -> str:
    """Return a distance between two people, their names, and its time."""
    if value is None:
        return ""
    one, other = value["between"]
    return f"{value['distance']:.2f} m ({one} and {other}) at {value['time']:.1f} s"


def nearest(value: Any, beside: Mapping[str, Any]) -> str:
    """Return a distance, its time, and the required distance."""
    if value is None:
        return ""
    distance, required = distinguished(value["distance"], value["required"])
    between = beside.get("distances_between", "centres")
    return f"{distance} m between {between} at {value['time']:.1f} s ({required} m required)"


def margin(value: Any, beside: Mapping[str, Any]) -> str:
    """Return a least margin, its person and machine, and its time."""
    if value is None:
        return ""
    between = f"{value['person']} and {value['machine']}"
    return f"{to_millimetres(value['value'])} m ({between}) at {value['time']:.1f} s"


def approaches(value: Any, beside: Mapping[str, Any]) -> str:
    """Return the number and duration of approaches, and the worst of them."""
    if not value["count"]:
        return ""
    between = f"{value['person']} and {value['machine']}"
    worst = f"least margin {to_millimetres(value['margin'])} m ({between}) at {value['time']:.1f} s"
    return f"{value['count']}, {value['duration']:.1f} s, {worst}"


def differences(value: Any, beside: Mapping[str, Any]) -> str:
    """Return the differences of a run to its counterfactual."""
    if "visits" in value:
        return (
            f"{value['visits']:+d} visits, {value['distance_walked']:+.1f} m walked,"
            f" {value['time_standing']:+.1f} s stood"
        )
    return f"{value['jobs_done']:+d} jobs, {value['gantry_idle_time']:+.1f} s idle"


def nearest_agv(value: Any, beside: Mapping[str, Any]) -> str:
    """Return a distance to an AGV, the person and the AGV, its time, and the required distance."""
    if value is None:
        return ""
    distance, required = distinguished(value["distance"], value["required"])
    between = f"{value['person']} and {value['agv']}"
    if beside.get("distances_between") == "surfaces":
        between = f"between surfaces, {between}"
    return f"{distance} m ({between}) at {value['time']:.1f} s ({required} m required)"


def short_laws(value: Any, beside: Mapping[str, Any]) -> str:
    """Return the machines that may take longer to stop than their law assumes."""
    vehicles = sum(short["law"] == "agv_law" for short in value)
    names = [short["machine"] for short in value if short["law"] != "agv_law"]
    return ", ".join([*names, *([f"{vehicles} vehicle{'s' * (vehicles > 1)}"] if vehicles else [])])


def program(value: Any, beside: Mapping[str, Any]) -> str:
    """Return the name of a personality."""
    return Path(value).stem


def counted(value: Any, beside: Mapping[str, Any]) -> str:
    """Return names with the number of their occurrences, in the order of the first ones."""
    return ", ".join(f"{name} {n}×" for name, n in Counter(value).items()) or "none"
