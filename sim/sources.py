"""What the user means by a word on the command line: a recording, a trial, or a floorplan."""

from __future__ import annotations

from pathlib import Path

import floorplan
from floorplan import Floorplan

from .outcome import Recorded
from .run_folder import load_run
from .simulation import run
from .trial import Trial


def run_from(source: str | Path) -> Recorded:
    """The run in the folder `source`, read back; or that of the trial `source`, which is run.

    Errors are those of `load_run`, `Trial.load` and `run`.
    """
    if Path(source).is_dir():
        return load_run(source)
    return run(Trial.load(source))


def floorplan_from(source: str | Path) -> Floorplan:
    """The floor of that name, in that file, of that trial, or of the run in that folder."""
    path = Path(source)
    if path.is_dir():
        return load_run(path).floorplan
    if path.name.endswith((".trial.yaml", ".trial.yml")):
        return Trial.load(path).floorplan
    return floorplan.load(source)
