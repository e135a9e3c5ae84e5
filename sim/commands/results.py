"""`floorwalker plot`, `render`, `metrics` and `export`: output of a recorded run."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from .arguments import Coordinate, Floor, GoalX, NoOwnCode, Radius, Source, StartX, complete_trial
from .terminal import plain_console, progress_bars, say

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.table import Table

    from ..runs.run import Recorded


app = typer.Typer(
    name="plot",
    help="Draw floors, paths and runs as PNG, SVG or PDF.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

Out = Annotated[Path, typer.Option(help="PNG, SVG or PDF file.")]
Columns = Annotated[
    Literal["single", "double"], typer.Option(help="Width: one or two columns of a paper.")
]
Begin = Annotated[float | None, typer.Option("--from", help="Begin in seconds.")]
End = Annotated[float | None, typer.Option("--to", help="End in seconds.")]

Sources = Annotated[
    list[str],
    typer.Argument(
        metavar="SOURCE...",
        help="Folders of runs, or trials to run, for one common map.",
        autocompletion=complete_trial,
    ),
]


@app.command()
def floorplan(
    floor: Floor,
    out: Out,
    width: Columns = "double",
    no_own_code: NoOwnCode = False,
) -> None:
    """Draw a floor from above with all names."""
    from ..views import plots
    from .sources import floorplan_from

    plots.require_savable(out)
    _save(plots.floorplan(floorplan_from(floor, own_code=not no_own_code), width=width), out)


@app.command(context_settings={"ignore_unknown_options": True})
def path(
    floor: Floor,
    x0: StartX,
    y0: Coordinate,
    x1: GoalX,
    y1: Coordinate,
    out: Out,
    radius: Radius = None,
    width: Columns = "double",
    no_own_code: NoOwnCode = False,
) -> None:
    """Draw a person's path across a floor, and the clearance along it."""
    from navigation import CollisionWorld, PathPlanner

    from ..views import plots
    from .sources import floorplan_from

    plots.require_savable(out)
    world = CollisionWorld(floorplan_from(floor, own_code=not no_own_code))
    wide = world.plan.human.radius if radius is None else radius
    planned = PathPlanner(world, wide).plan((x0, y0), (x1, y1))
    _save(plots.path(world, planned, radius=wide, width=width), out)


@app.command()
def trails(
    source: Source,
    out: Out,
    begin: Begin = None,
    end: End = None,
    width: Columns = "double",
    no_own_code: NoOwnCode = False,
) -> None:
    """Draw the paths of people and machines, and mark violations."""
    run = _run(source, out, own_code=not no_own_code)
    _save(run.plot.trails(within=_within(begin, end), width=width), out)


@app.command()
def spacetime(
    source: Source,
    out: Out,
    begin: Begin = None,
    end: End = None,
    width: Columns = "double",
    no_own_code: NoOwnCode = False,
) -> None:
    """Draw a space–time diagram: x and y of people and machines over time."""
    run = _run(source, out, own_code=not no_own_code)
    _save(run.plot.space_time(within=_within(begin, end), width=width), out)


@app.command()
def separation(
    source: Source,
    out: Out,
    person: Annotated[
        list[str] | None,
        typer.Option(
            help="Person; repeat for more (default: all, or those with the least margin)."
        ),
    ] = None,
    machine: Annotated[
        str | None,
        typer.Option(help="Machine (default: the first robot, or the most critical AGV)."),
    ] = None,
    begin: Begin = None,
    end: End = None,
    width: Columns = "double",
    no_own_code: NoOwnCode = False,
) -> None:
    """Draw distance and required distance over time, with violations shaded."""
    run = _run(source, out, own_code=not no_own_code)
    figure = run.plot.separation(person or None, machine, within=_within(begin, end), width=width)
    _save(figure, out)


@app.command()
def heatmap(
    sources: Sources,
    out: Out,
    width: Columns = "double",
    no_own_code: NoOwnCode = False,
) -> None:
    """Draw the time that people spent in each place."""
    from ..views import plots

    runs = [_run(source, out, own_code=not no_own_code) for source in sources]
    _save(plots.heat_map(runs, width=width), out)


@app.command()
def density(
    sources: Sources,
    out: Out,
    of: Annotated[
        Literal["density", "speed"], typer.Option(help="Density (1/m²) or speed (m/s).")
    ] = "density",
    begin: Begin = None,
    end: End = None,
    width: Columns = "double",
    no_own_code: NoOwnCode = False,
) -> None:
    """Draw the mean density or speed of people on the floor."""
    from ..views import plots

    runs = [_run(source, out, own_code=not no_own_code) for source in sources]
    _save(plots.density_map(runs, of=of, within=_within(begin, end), width=width), out)


@app.command()
def riskmap(
    sources: Sources,
    out: Out,
    of: Annotated[
        Literal["margin", "time", "severity"],
        typer.Option(
            help="Least margin to the required distance, duration of violations, or highest"
            " relative speed in violations."
        ),
    ] = "margin",
    width: Columns = "double",
    no_own_code: NoOwnCode = False,
) -> None:
    """Draw where people came closer to machines than required, or almost."""
    from ..views import plots

    runs = [_run(source, out, own_code=not no_own_code) for source in sources]
    _save(plots.risk_map(runs, of=of, width=width), out)


def _run(source: str, out: Path, *, own_code: bool) -> Recorded:
    """Return the run to draw into `out`, after checking that `out` can be written."""
    from ..views import plots
    from .sources import run_from

    plots.require_savable(out)
    return run_from(source, own_code=own_code)


def _within(begin: float | None, end: float | None) -> tuple[float, float] | None:
    if begin is None and end is None:
        return None
    return (begin or 0.0, float("inf") if end is None else end)


def _save(figure: Figure, out: Path) -> None:
    from ..views import plots

    plots.save(figure, out)
    if note := figure.get_supxlabel():
        say(note.replace("\n", " "), err=True)
    say(str(out))


def render(
    source: Source,
    out: Annotated[Path, typer.Option(help="GIF or MP4 file.")],
    speed: Annotated[float, typer.Option(help="Simulated seconds per second of the film.")] = 8.0,
    fps: Annotated[int, typer.Option(help="Pictures per second.")] = 20,
    width: Annotated[int, typer.Option(help="Width in pixels.")] = 720,
    begin: Annotated[float, typer.Option("--from", help="Begin in seconds.")] = 0.0,
    end: Annotated[float | None, typer.Option("--to", help="End in seconds.")] = None,
    view: Annotated[
        Literal["2d", "3d", "eyes"],
        typer.Option(help="From above, in three dimensions, or through the eyes of a person."),
    ] = "2d",
    follow: Annotated[
        str,
        typer.Option(metavar="NAME", help="Body in the centre, or person of the view 'eyes'."),
    ] = "",
    dark: Annotated[bool, typer.Option("--dark", help="Use dark colours.")] = False,
    no_own_code: NoOwnCode = False,
) -> None:
    """Film a run as GIF or MP4. This needs Chromium and the extra `film`."""
    from ..views import film
    from .sources import run_from

    film.require_renderable(out)
    run = run_from(source, own_code=not no_own_code)
    within = (begin, float("inf") if end is None else end)
    with progress_bars() as progress:
        bar = progress.add_task("filming", total=1.0)
        film.render(
            run,
            out,
            speed=speed,
            fps=fps,
            width=width,
            within=within,
            view=view,
            follow=follow,
            dark=dark,
            progress=lambda share: progress.update(bar, completed=share),
        )
    say(str(out))


def metrics(
    source: Source,
    radius: Annotated[
        list[str] | None,
        typer.Option(
            metavar="BODY=M", help="Radius (m) to subtract from distances; repeat for more bodies."
        ),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    no_own_code: NoOwnCode = False,
) -> None:
    """Measure paths, speeds, distances and intrusions into personal space."""
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
    console.print(_table_of("Motion", _MOVEMENTS, bodies))
    console.print(_table_of("Progress", _PROGRESS, bodies))
    if figures["people"]:
        title = "Distance between centres, and share of time in each space of people"
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
    """Return a table of figures, whose heads are `columns` by key."""
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
    "time_not_moving": "at\nrest\ns",
    "maximum_speed": "top\nspeed\nm/s",
    "average_speed": "mean\nspeed\nm/s",
    "average_acceleration": "mean\naccel.\nm/s²",
    "average_jerk": "mean\njerk\nm/s³",
}
_PROGRESS = {
    "goals": "goals",
    "goals_reached": "reached",
    "time_to_goal": "time to goal\ns",
    "final_distance_to_goal": "final distance\nto goal m",
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


def export(
    source: Source,
    out: Annotated[
        Path,
        typer.Option(
            help="File: .csv, .parquet, .mcap (Foxglove) or .sqlite (JuPedSim), or a new folder"
            " for a ROS 2 bag."
        ),
    ],
    format: Annotated[
        Literal["csv", "parquet", "mcap", "rosbag", "jupedsim"] | None,
        typer.Option(help="Format, if it is not defined by the suffix."),
    ] = None,
    rate: Annotated[float, typer.Option(help="Sampling rate in Hz.")] = 20.0,
    no_own_code: NoOwnCode = False,
) -> None:
    """Export a sampled run to the format of another tool."""
    from ..exports import Export
    from .sources import run_from

    chosen = Export.to(out, rate=rate, format=format)
    run = run_from(source, own_code=not no_own_code)
    chosen.write(run)
    say(f"Wrote {run.duration:g} s of {run.scene.trial} at {rate:g} Hz to {out}")
