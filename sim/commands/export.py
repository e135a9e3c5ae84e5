"""`floorwalker export`: a run in the format of another tool."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from .arguments import NoOwnCode, Source
from .consoles import say


def export(
    source: Source,
    out: Annotated[
        Path,
        typer.Option(
            help="What to write: .csv, .parquet, .mcap (Foxglove), .sqlite (JuPedSim), or a new"
            " folder for a ROS 2 bag."
        ),
    ],
    format: Annotated[
        Literal["csv", "parquet", "mcap", "rosbag", "jupedsim"] | None,
        typer.Option(help="If the name of the file does not say it."),
    ] = None,
    rate: Annotated[float, typer.Option(help="Instants a second, in Hz.")] = 20.0,
    no_own_code: NoOwnCode = False,
) -> None:
    """Write a run in the format of another tool.

    Places are sampled from the exact motions.
    """
    from sim.commands.sources import run_from
    from sim.exports import Export

    chosen = Export.to(out, rate=rate, format=format)
    run = run_from(source, own_code=not no_own_code)
    chosen.write(run)
    say(f"{out} holds {run.duration:g} s of {run.scene.trial} at {rate:g} Hz")
