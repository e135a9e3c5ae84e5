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
    bodies = figures["people"] | figures["machines"]
    console.print(_table_of("How they moved", _MOVEMENTS, bodies))
    console.print(_table_of("How they got on", _PROGRESS, bodies))
    if figures["people"]:
        title = "How far apart they were, and for how much of the time in whose space"
        console.print(_table_of(title, _DISTANCES, _distances(figures)))


def _radius(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        radius = float(value)
    except ValueError:
        radius = math.nan
    if not (name and math.isfinite(radius)):
        raise typer.BadParameter(f"expected BODY=METRES, found {text!r}", param_hint="--radius")
    return name, radius


def _table_of(title: str, columns: dict[str, str], rows: dict[str, dict[str, Any]]) -> Table:
    """Return a table of figures: `columns` has the heads by the keys of figures."""
    from rich.table import Table

    table = Table("", title=title, title_justify="left")
    for label in columns.values():
        table.add_column(label, justify="right", overflow="fold")
    for name, figures in rows.items():
        table.add_row(name, *(_text(figures.get(key)) for key in columns))
    return table


def _distances(figures: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the distances of each pair, of the nearest of several people, and of groups."""
    people = list(figures["people"])
    rows = {
        f"{name} – {other}": distances
        for k, name in enumerate(people)
        for other, distances in figures["people"][name]["distance_to"].items()
        if other not in people[:k]
    }
    if len(people) > 1:
        rows |= {
            f"{name} – nearest": machine["distance_to_people"]
            for name, machine in figures["machines"].items()
        }
    return rows | {
        f"{name} – group of {leader}": distances
        for name, body in (figures["people"] | figures["machines"]).items()
        for leader, distances in body.get("distance_to_groups", {}).items()
    }


_MOVEMENTS = {
    "time": "time\ns",
    "path_length": "path\nm",
    "cumulative_heading_changes": "turned\nrad",
    "time_not_moving": "not\nmoving\ns",
    "maximum_speed": "top\nspeed\nm/s",
    "average_speed": "mean\nspeed\nm/s",
    "average_acceleration": "mean\naccel.\nm/s²",
    "average_jerk": "mean\njerk\nm/s³",
}
_PROGRESS = {
    "goals": "goals",
    "goals_reached": "reached",
    "time_to_goal": "time to goal\ns",
    "final_distance_to_goal": "left at the end\nm",
    "social_work": "social work\nm/s",
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
