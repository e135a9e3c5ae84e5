"""`floorwalker plan`: the path from one place on a floor to another."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from . import completion
from .arguments import Coordinate, GoalX, Radius, StartX
from .consoles import say

if TYPE_CHECKING:
    from navigation import CollisionWorld
    from navigation import Path as PlannedPath


def plan(
    floorplan: Annotated[
        str,
        typer.Argument(help="A built-in name, or a file.", autocompletion=completion.floor),
    ],
    x0: StartX,
    y0: Coordinate,
    x1: GoalX,
    y1: Coordinate,
    planner: Annotated[
        str | None,
        typer.Option(
            help='Its name, or "BITstar: {samples_per_batch: 50}"; `floorwalker list` has all.',
            autocompletion=completion.planner,
        ),
    ] = None,
    parameter: Annotated[
        list[str] | None,
        typer.Option(help="NAME=VALUE of one of the planner's parameters; again for more."),
    ] = None,
    radius: Radius = None,
    agv: Annotated[
        list[str] | None,
        typer.Option(help="NAME=PLACE: an AGV's location or lane position; again for more."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of planners that draw samples.")] = 0,
    json: Annotated[bool, typer.Option("--json", help="Print the path as JSON.")] = False,
    plot: Annotated[
        Path | None, typer.Option(help="Draw floor and path into this PNG, SVG or PDF.")
    ] = None,
) -> None:
    """Plan a person's path from (X0, Y0) to (X1, Y1), in metres."""
    import time

    import floorplan as floors
    import navigation
    from sim.people.planners import find_planner

    world = navigation.CollisionWorld(floors.load(floorplan))
    for name, place in _pairs(agv or [], "--agv"):
        _move(world, name, place)
    parameters = {name: _value(text) for name, text in _pairs(parameter or [], "--parameter")}
    choice = navigation.PlannerChoice() if planner is None else navigation.PlannerChoice.of(planner)
    seeker = navigation.PathPlanner(world, radius, planner=find_planner(choice, Path()))
    begin = time.process_time()
    planned = seeker.plan((x0, y0), (x1, y1), parameters=parameters, seed=seed)
    cpu_seconds = time.process_time() - begin
    if plot is not None:
        _draw(world, planned, seeker.radius, plot)
    say(_as_json(planned, cpu_seconds) if json else _in_words(planned, cpu_seconds))


def _pairs(texts: list[str], option: str) -> list[tuple[str, str]]:
    pairs = []
    for text in texts:
        name, equals, value = text.partition("=")
        if not (name and equals and value):
            raise typer.BadParameter(f"expected NAME=VALUE, found {text!r}", param_hint=option)
        pairs.append((name, value))
    return pairs


def _move(world: CollisionWorld, name: str, place: str) -> None:
    from floorplan import UserError

    try:
        world.move_agv(name, float(_value(place)) if _is_number(place) else place)
    except KeyError as why:
        raise UserError(why.args[0]) from None


def _is_number(text: str) -> bool:
    return isinstance(_value(text), (int, float)) and not isinstance(_value(text), bool)


def _value(text: str) -> float | int | bool | str:
    """Return `text` as the number or yes/no that it spells, or as it is."""
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def _in_words(planned: PlannedPath, cpu_seconds: float) -> str:
    lines = [
        f"{planned.length:.3f} m by {planned.planner}, {planned.clearance:.3f} m clear,"
        f" {planned.checks} checks, {1000 * cpu_seconds:.1f} ms"
    ]
    lines += [f"  {x:9.3f} {y:9.3f}" for x, y in planned.points]
    return "\n".join(lines)


def _as_json(planned: PlannedPath, cpu_seconds: float) -> str:
    import json

    return json.dumps(
        {
            "points": planned.points.tolist(),
            "length": planned.length,
            "clearance": planned.clearance,
            "planner": planned.planner,
            "checks": planned.checks,
            "cpu_seconds": cpu_seconds,
        }
    )


def _draw(world: CollisionWorld, planned: PlannedPath, radius: float, path: Path) -> None:
    from sim.views import plots

    plots.save(plots.path(world, planned, radius=radius), path)
