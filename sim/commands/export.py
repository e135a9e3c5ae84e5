"""`floorwalker export`: a run in the format of another tool."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from . import completion
from .arguments import NoOwnCode
from .consoles import say


class FormatName(str, Enum):
    """Formats that `--format` can name."""

    csv = "csv"
    parquet = "parquet"
    mcap = "mcap"
    rosbag = "rosbag"
    jupedsim = "jupedsim"


def export(
    source: Annotated[
        str,
        typer.Argument(
            metavar="DIR|TRIAL",
            help="A recording's folder; or a trial (a file or a built-in name), which is run.",
            autocompletion=completion.trial,
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            help="What to write: .csv, .parquet, .mcap (Foxglove), .sqlite (JuPedSim), or a new"
            " folder for a ROS 2 bag."
        ),
    ],
    format: Annotated[
        FormatName | None, typer.Option(help="If the name of the file does not say it.")
    ] = None,
    rate: Annotated[float, typer.Option(help="Instants a second, in Hz.")] = 20.0,
    no_own_code: NoOwnCode = False,
) -> None:
    """Write a run in the format of another tool, sampled from the exact motions."""
    from sim.commands.sources import run_from
    from sim.exports import Export

    name = format.value if format is not None else None
    chosen = Export.to(out, rate=rate, format=name)
    run = run_from(source, own_code=not no_own_code)
    chosen.write(run)
    say(f"{out} holds {run.duration:g} s of {run.scene.trial} at {rate:g} Hz")
