"""Arguments and options of several commands, and their completion in the shell.

Completion runs on every Tab, so that names are found without loading their objects.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

import typer

CONTROLLERS = ("avoiding", "external", "oblivious", "parked", "pausing")
RULE_SETS = ("ariac2023", "observe", "paper", "protective_stop")
PLANNERS = (
    *("Roadmap", "AORRTC", "BFMT", "BITstar", "BKPIECE1", "FMT", "InformedRRTstar", "KPIECE1"),
    *("LBKPIECE1", "PRM", "PRMstar", "RRT", "RRTConnect", "RRTstar", "SORRTstar"),
)
PEERS = ("JuPedSim", "extremitypathfinder", "pyastar2d", "scikit-image", "PRM-of-corners")
BACKENDS = ("loky", "dask", "threading", "sequential")
YAML = (".yaml", ".yml")
FLOORS = (*YAML, ".wkt", ".dxf", ".map")


def complete_trial(incomplete: str) -> list[str]:
    """Complete a built-in trial, a file, or the folder of a run."""
    return _offer(incomplete, _data("sim", "data/trials/*.yaml"), YAML)


def complete_study(incomplete: str) -> list[str]:
    """Complete the file of a study."""
    return _offer(incomplete, (), YAML)


def complete_floor(incomplete: str) -> list[str]:
    """Complete a built-in floorplan or a file."""
    return _offer(incomplete, _floors(), FLOORS)


def complete_program(incomplete: str) -> list[str]:
    """Complete a personality or the file of an AgentSpeak program."""
    return _offer(incomplete, _personalities(), (".asl",))


def complete_rules(incomplete: str) -> list[str]:
    """Complete a built-in rule set or a file."""
    return _offer(incomplete, RULE_SETS, YAML)


def complete_controller(incomplete: str) -> list[str]:
    """Complete a built-in controller of gantries and vehicles."""
    return _offer(incomplete, CONTROLLERS)


def complete_planner(incomplete: str) -> list[str]:
    """Complete the roadmap or a planner that every supported OMPL has."""
    return _offer(incomplete, PLANNERS)


def complete_contender(incomplete: str) -> list[str]:
    """Complete a planner of this or another package."""
    return _offer(incomplete, (*PLANNERS, *PEERS))


def complete_questions(incomplete: str) -> list[str]:
    """Complete a file with queries for planners."""
    return _offer(incomplete, (), (".csv", ".scen"))


def complete_backend(incomplete: str) -> list[str]:
    """Complete a backend that can run the rows of a study."""
    return _offer(incomplete, BACKENDS)


def complete_floor_source(incomplete: str) -> list[str]:
    """Complete a floorplan, a trial, or the folder of a run."""
    names = {*_floors(), *_data("sim", "data/trials/*.yaml")}
    return _offer(incomplete, sorted(names), FLOORS)


def complete_checked(incomplete: str) -> list[str]:
    """Complete all files that `floorwalker check` reads."""
    names = {*_floors(), *_personalities(), *RULE_SETS, *_data("sim", "data/trials/*.yaml")}
    return _offer(incomplete, sorted(names), (*FLOORS, ".asl"))


def _floors() -> list[str]:
    return _data("floorplan", "data/*.yaml")


def _personalities() -> list[str]:
    return [name for name in _data("bdi", "personalities/*.asl") if name not in ("patrol", "group")]


def _data(package: str, pattern: str) -> list[str]:
    """Return the names of a package's data files without importing the package."""
    spec = find_spec(package)
    folders = spec.submodule_search_locations if spec is not None else None
    return sorted(file.stem for folder in folders or () for file in Path(folder).glob(pattern))


def _offer(incomplete: str, names: Iterable[str], endings: tuple[str, ...] = ()) -> list[str]:
    begun = [name for name in names if name.startswith(incomplete)]
    return [*begun, *_files(incomplete, endings)] if endings else begun


def _files(incomplete: str, endings: tuple[str, ...], *, deeper: bool = True) -> list[str]:
    """Return the folders, and the files with one of `endings`, that begin with `incomplete`.

    The contents of a single folder are offered, because shells would put a blank after the folder.
    For the same reason names with blanks are omitted.
    """
    parent, _, beginning = incomplete.rpartition("/")
    above = f"{parent}/" if "/" in incomplete else ""
    try:
        entries = sorted(os.scandir(above or "."), key=lambda entry: entry.name)
    except OSError:
        return []
    names = [
        f"{above}{entry.name}/" if entry.is_dir() else f"{above}{entry.name}"
        for entry in entries
        if entry.name.startswith(beginning)
        and entry.name.startswith(".") == beginning.startswith(".")
        and (entry.is_dir() or entry.name.endswith(endings))
        and not any(map(str.isspace, entry.name))
    ]
    if deeper and len(names) == 1 and names[0].endswith("/"):
        return _files(names[0], endings, deeper=False) or names
    return names


TrialName = Annotated[
    str,
    typer.Argument(
        metavar="TRIAL",
        help="Trial file, or name of a built-in trial.",
        autocompletion=complete_trial,
    ),
]
Source = Annotated[
    str,
    typer.Argument(
        metavar="SOURCE",
        help="Folder of a run, or a trial to run.",
        autocompletion=complete_trial,
    ),
]
Floor = Annotated[
    str,
    typer.Argument(
        metavar="FLOOR",
        help="Floorplan, trial, or folder of a run.",
        autocompletion=complete_floor_source,
    ),
]
StartX = Annotated[float, typer.Argument(help="Start: x and y in metres.")]
GoalX = Annotated[float, typer.Argument(help="Goal: x and y in metres.")]
Coordinate = Annotated[float, typer.Argument()]
Radius = Annotated[
    float | None, typer.Option(help="Radius of the person in metres (default: that of the floor).")
]
Personality = Annotated[
    str | None,
    typer.Option(
        help="Personality of all people: a name or an .asl file.",
        autocompletion=complete_program,
    ),
]
Duration = Annotated[float | None, typer.Option(help="Duration in seconds.")]
Seed = Annotated[int | None, typer.Option(min=0, help="Random seed.")]
Rules = Annotated[
    str | None,
    typer.Option(help="Rule set: a name or a YAML file.", autocompletion=complete_rules),
]
NoOwnCode = Annotated[
    bool,
    typer.Option("--no-own-code", help="Reject custom Python code."),
]
RecordingFolder = Annotated[
    Path | None, typer.Option(help="Folder of the recording (default: runs/TRIAL).")
]
