"""Arguments and options that several commands take."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from . import completion

TrialName = Annotated[
    str,
    typer.Argument(
        metavar="TRIAL",
        help="A file, or the name of a built-in trial.",
        autocompletion=completion.trial,
    ),
]
Source = Annotated[
    str,
    typer.Argument(
        metavar="SOURCE",
        help="A run's folder, or a trial (which is run).",
        autocompletion=completion.trial,
    ),
]
Floor = Annotated[
    str,
    typer.Argument(
        metavar="FLOOR",
        help="A floorplan, a trial, or a run's folder.",
        autocompletion=completion.floor_source,
    ),
]
StartX = Annotated[float, typer.Argument(help="The start, in metres.")]
GoalX = Annotated[float, typer.Argument(help="The goal, in metres.")]
Coordinate = Annotated[float, typer.Argument()]
Radius = Annotated[
    float | None, typer.Option(help="Of the person, in metres; the floor's own by default.")
]
Personality = Annotated[
    str | None,
    typer.Option(
        help="Of everybody in the trial: a name, or an .asl file.",
        autocompletion=completion.program,
    ),
]
Duration = Annotated[float | None, typer.Option(help="Seconds to simulate.")]
Seed = Annotated[int | None, typer.Option(min=0, help="Seed of everything random.")]
Rules = Annotated[
    str | None,
    typer.Option(help="Rule set: a name, or a YAML file.", autocompletion=completion.rules),
]
NoOwnCode = Annotated[
    bool,
    typer.Option("--no-own-code", help="Refuse trials that name Python of somebody's own."),
]
RecordingFolder = Annotated[
    Path | None, typer.Option(help="Folder for the recording (runs/TRIAL if not given).")
]
