"""Meaning of an argument: a recording, a trial, or a floorplan."""

from __future__ import annotations

from pathlib import Path

import floorplan
from floorplan import Floorplan
from floorplan.files.documents import read_yaml
from floorplan.files.reading import is_file

from ..runs.recording import load_run
from ..runs.run import Recorded
from ..simulation import run
from ..trials.building import lasting
from ..trials.checks import check
from ..trials.trial import Trial, builtin_trials


def run_from(
    source: str | Path, duration: float | None = None, *, own_code: bool = True
) -> Recorded:
    """Return the run in the folder `source`, or run the trial `source` for `duration` seconds.

    `own_code` is as in `Trial.load`. Errors are those of `load_run`, `Trial.load` and `run`.
    """
    if Path(source).is_dir():
        return load_run(source)
    trial = Trial.load(source, own_code=own_code)
    if duration is not None:
        trial = lasting(trial, duration)
        check(trial)
    return run(trial)


def floorplan_from(source: str | Path, *, own_code: bool = True) -> Floorplan:
    """Return the floor of that name or file, of that trial, or of the run in that folder.

    A name of both a floorplan and a trial means the floorplan. `own_code` is as in `Trial.load`.
    """
    path, name = Path(source), str(source)
    if path.is_dir():
        return load_run(path).floorplan
    if name in set(builtin_trials()) - set(floorplan.builtin()) or _is_trial(path):
        return Trial.load(source, own_code=own_code).floorplan
    return floorplan.load(source)


def is_study(source: str | Path) -> bool:
    """Return True if `source` is a YAML file of a study."""
    return "trials" in outermost_keys(Path(source))


def _is_trial(path: Path) -> bool:
    """Return True if a YAML file names a floorplan instead of being one."""
    return "floorplan" in outermost_keys(path)


def outermost_keys(path: Path) -> set[str]:
    """Return the outermost keys of a YAML file, or none for other files."""
    if path.suffix.lower() not in (".yaml", ".yml") or not is_file(path):
        return set()
    data = read_yaml(path, floorplan.FloorplanError).data
    return set(data) if isinstance(data, dict) else set()
