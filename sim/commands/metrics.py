"""`floorwalker metrics`: the metrics of social navigation of a run."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .arguments import NoOwnCode, Source
from .consoles import plain_console, say

if TYPE_CHECKING:
    from rich.table import Table


def metrics(
    source: Source,
    radius: Annotated[
        list[str] | None,
        typer.Option(
            metavar="BODY=M", help="Take this radius off the distances of a body; may be repeated."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    no_own_code: NoOwnCode = False,
) -> None:
    """Measure paths, speeds, distances and personal space in a run."""
    import json

    from ..record.social_metrics import metrics as measured
    from .sources import run_from

    radii = dict(map(_radius, radius or []))
    figures = measured(run_from(source, own_code=not no_own_code), radii=radii)
    if as_json:
        say(json.dumps(figures, indent=2, ensure_ascii=False))
        return
    console = plain_console()
    console.print(_movements(figures))
    if figures["people"]:
        console.print(_distances(figures))


def _radius(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        radius = float(value)
    except ValueError:
        radius = math.nan
    if not (name and math.isfinite(radius)):
        raise typer.BadParameter(f"expected BODY=METRES, found {text!r}", param_hint="--radius")
    return name, radius


def _movements(figures: dict[str, Any]) -> Table:
    """Return the table of motions: a column for each body."""
    from rich.table import Table

    bodies = figures["people"] | figures["machines"]
    table = Table("", title="How they moved", title_justify="left")
    for name in bodies:
        table.add_column(name, justify="right")
    for key, label in _MOVEMENTS.items():
        table.add_row(label, *(_text(figures.get(key)) for figures in bodies.values()))
    return table


def _distances(figures: dict[str, Any]) -> Table:
    """Return the table of distances: a row for each pair, and for the nearest of several people."""
    from rich.table import Table

    rows = {
        f"{name} – {other}": distances
        for name, person in figures["people"].items()
        for other, distances in person["distance_to"].items()
    }
    if len(figures["people"]) > 1:
        rows |= {
            f"{name} – nearest": machine["distance_to_people"]
            for name, machine in figures["machines"].items()
        }
    rows |= {
        f"{name} – group of {leader}": distances
        for name, body in (figures["people"] | figures["machines"]).items()
        for leader, distances in body.get("distance_to_groups", {}).items()
    }
    title = "How far apart they were, and for how much of the time in whose space"
    table = Table("", title=title, title_justify="left")
    for label in _DISTANCES.values():
        table.add_column(label, justify="right")
    for name, distances in rows.items():
        table.add_row(name, *(_text(distances[key]) for key in _DISTANCES))
    return table


_MOVEMENTS = {
    "time": "time, s",
    "path_length": "path length, m",
    "cumulative_heading_changes": "heading changes, rad",
    "time_not_moving": "not moving, s",
    "maximum_speed": "maximum speed, m/s",
    "average_speed": "average speed, m/s",
    "average_acceleration": "average acceleration, m/s²",
    "average_jerk": "average jerk, m/s³",
    "social_work": "social work, m/s",
    "goals": "goals",
    "goals_reached": "goals reached",
    "time_to_goal": "time to goal, s",
    "final_distance_to_goal": "final distance to goal, m",
}
_DISTANCES = {
    "average": "mean\nm",
    "minimum": "least\nm",
    "maximum": "most\nm",
    "intimate_space_intrusions": "intimate\n%",
    "personal_space_intrusions": "personal\n%",
    "social_space_intrusions": "social\n%",
}


def _text(value: float | None) -> str:
    if value is None:
        return "–"
    return str(value) if isinstance(value, int) else f"{value:.2f}"
