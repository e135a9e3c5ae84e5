"""Code of the user's own that a trial names, and if a file in some folder may name it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ..core.scenario import Scenario
from ..machines.gantry.controllers import CONTROLLERS
from ..machines.kinds import is_own
from ..safety.own_law import own_laws


def own_names(trial: Scenario) -> Iterator[str]:
    """Yield the names of all own code that stands in the trial's folder."""
    controller = trial.gantry.controller
    if controller not in (*CONTROLLERS, *CONTROLLERS.values()):
        yield trial.gantry.controller_name
    planners = (trial.planner, *(person.planner for person in trial.people))
    yield from dict.fromkeys(one.name for one in planners if one is not None and one.is_own)
    if trial.steering is not None:
        yield trial.steering
    modules = (trial.actions, *(person.actions for person in trial.people))
    yield from dict.fromkeys(name for name in modules if name is not None)
    yield from (str(entry.kind) for entry in trial.machines.values() if is_own(entry))
    for law in dict.fromkeys(own_laws(trial.rules)):
        if law.folder == trial.folder.resolve():
            yield law.name


def out_of_reach(trial: Scenario, folder: Path) -> str:
    """Return the fault of a file in `folder` that holds `trial`, or an empty text.

    The code that a file names stands in its folder, or in one below or above it to which its
    `folder` leads; so no file leads to code that is installed, or that has nothing to do with it.
    """
    here, there = folder.resolve(), trial.folder.resolve()
    names = ", ".join(own_names(trial))
    if not names or here.is_relative_to(there) or there.is_relative_to(here):
        return ""
    return f"its code, {names}, stands in {there}: so does a trial that names it, or below"
