"""`floorwalker convert`: write a floor in another format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from . import completion
from .consoles import say
from .notices import print_floor_notices


def convert(
    source: Annotated[
        str,
        typer.Argument(
            metavar="IN", help="A built-in name, or a file.", autocompletion=completion.floor
        ),
    ],
    target: Annotated[
        Path,
        typer.Argument(metavar="OUT", help="Ends in .yaml, .wkt, .geojson, or .pgm (a ROS map)."),
    ],
    resolution: Annotated[
        float | None,
        typer.Option(help="Of a ROS map: metres per cell, 0.05 if it is not given."),
    ] = None,
) -> None:
    """Write the floor IN in the format of OUT. A --resolution makes a .yaml a ROS map."""
    import floorplan

    plan = floorplan.load(source)
    print_floor_notices(plan)
    suffix = ".pgm" if resolution is not None else target.suffix.lower()
    files = floorplan.map_files(target) if suffix == ".pgm" else (target,)
    written = sorted(files, key=lambda file: file != target)  # OUT itself comes first
    if Path(source).exists():
        for one in written:
            if one.exists() and one.samefile(source):
                raise floorplan.UserError(
                    f"{target}: {one} would take the place of IN; give another name"
                )
    plan.save(target, resolution=resolution)
    if lost := floorplan.lost(plan, suffix):
        say(f"{target} has no room for: {', '.join(lost)}", err=True)
    say(f"Wrote {' and '.join(map(str, written))}")
