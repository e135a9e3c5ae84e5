"""`floorwalker plot`: pictures of floors, paths and runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from . import completion
from .arguments import Coordinate, Floor, GoalX, NoOwnCode, Radius, Source, StartX
from .consoles import say

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from sim import Recorded

app = typer.Typer(
    name="plot",
    help="Draw floors, paths and runs as PNG, SVG or PDF.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

Out = Annotated[Path, typer.Option(help="The picture: its ending says which kind.")]
Columns = Annotated[
    Literal["single", "double"], typer.Option(help="How many columns of a paper it takes.")
]
Begin = Annotated[float | None, typer.Option("--from", help="Draw from this time on, seconds.")]
End = Annotated[float | None, typer.Option("--to", help="Draw up to this time, seconds.")]

Sources = Annotated[
    list[str],
    typer.Argument(
        metavar="SOURCE...",
        help="Runs' folders, or trials (which are run); all in one map.",
        autocompletion=completion.trial,
    ),
]


@app.command()
def floorplan(
    floor: Floor,
    out: Out,
    width: Columns = "double",
    no_own_code: NoOwnCode = False,
) -> None:
    """The floor from above, with everything that has a name."""
    from sim.commands.sources import floorplan_from
    from sim.views import plots

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
    """A person's path across a floor, and how much room there is along it."""
    from navigation import CollisionWorld, PathPlanner
    from sim.commands.sources import floorplan_from
    from sim.views import plots

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
    """The paths that people and machines took, and where somebody came too close."""
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
    """A space–time diagram: x and y of everybody who moves, over time."""
    run = _run(source, out, own_code=not no_own_code)
    _save(run.plot.space_time(within=_within(begin, end), width=width), out)


@app.command()
def separation(
    source: Source,
    out: Out,
    person: Annotated[
        list[str] | None,
        typer.Option(
            help="May be repeated; if not given everybody, or of many those with the least margin."
        ),
    ] = None,
    machine: Annotated[
        str | None, typer.Option(help="gantry, or an AGV by name; the first there is if not given.")
    ] = None,
    begin: Begin = None,
    end: End = None,
    width: Columns = "double",
    no_own_code: NoOwnCode = False,
) -> None:
    """Distance and required distance over time, violations shaded."""
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
    """Time that people spent at each place."""
    from sim.views import plots

    runs = [_run(source, out, own_code=not no_own_code) for source in sources]
    _save(plots.heat_map(runs, width=width), out)


@app.command()
def density(
    sources: Sources,
    out: Out,
    of: Annotated[
        Literal["density", "speed"], typer.Option(help="People per m², or how fast they are.")
    ] = "density",
    begin: Begin = None,
    end: End = None,
    width: Columns = "double",
    no_own_code: NoOwnCode = False,
) -> None:
    """Mean density of people over the floor, or their mean speed."""
    from sim.views import plots

    runs = [_run(source, out, own_code=not no_own_code) for source in sources]
    _save(plots.density_map(runs, of=of, within=_within(begin, end), width=width), out)


@app.command()
def riskmap(
    sources: Sources,
    out: Out,
    of: Annotated[
        Literal["margin", "time", "severity"],
        typer.Option(
            help="The least margin to the required distance, the time without it, or the highest"
            " relative speed then."
        ),
    ] = "margin",
    width: Columns = "double",
    no_own_code: NoOwnCode = False,
) -> None:
    """Where people came nearer to machines than the rules require, or nearly so."""
    from sim.views import plots

    runs = [_run(source, out, own_code=not no_own_code) for source in sources]
    _save(plots.risk_map(runs, of=of, width=width), out)


def _run(source: str, out: Path, *, own_code: bool) -> Recorded:
    """Return the run to be drawn into `out`, if that can be done at all."""
    from sim.commands.sources import run_from
    from sim.views import plots

    plots.require_savable(out)
    return run_from(source, own_code=own_code)


def _within(begin: float | None, end: float | None) -> tuple[float, float] | None:
    if begin is None and end is None:
        return None
    return (begin or 0.0, float("inf") if end is None else end)


def _save(figure: Figure, out: Path) -> None:
    from sim.views import plots

    plots.save(figure, out)
    if note := figure.get_supxlabel():
        say(note.replace("\n", " "), err=True)
    say(str(out))
