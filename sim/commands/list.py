"""`floorwalker list`: everything that comes with Floorwalker, by name."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

from .consoles import say


def list_all() -> None:
    """List what comes with Floorwalker.

    That is floorplans, trials, planners, personalities, gantry controllers and rule sets.
    """
    import bdi
    import floorplan
    import navigation

    from ..core.rules import RULE_SETS
    from ..machines.gantry.controllers import CONTROLLERS
    from ..trials.trial import BUILT_IN, builtin_trials

    sections = {
        "floorplans": {name: floorplan.load(name).title for name in floorplan.builtin()},
        "trials": {name: _opening(BUILT_IN / f"{name}.yaml", "#") for name in builtin_trials()},
        "planners": {info.name: info.summary for info in navigation.planners()},
        "personalities": {
            name: _opening(path, "//").partition(": ")[2] for name, path in bdi.programs().items()
        },
        "controllers": {
            name: (controller.__doc__ or "").split("\n")[0].rstrip(".")
            for name, controller in CONTROLLERS.items()
        },
        "rule sets": {rules.name: rules.summary for rules in RULE_SETS.values()},
    }
    width = max(len(name) for section in sections.values() for name in section)
    for title, entries in sections.items():
        say(title)
        for name, summary in entries.items():
            say(f"  {name:<{width}}  {summary}".rstrip())


def _opening(file: Path, mark: str) -> str:
    """Return the first sentence of the comment that a file begins with, after a `mark` a line."""
    lines = file.read_text(encoding="utf-8").splitlines()
    comment = " ".join(
        line.removeprefix(mark).strip()
        for line in itertools.takewhile(lambda line: line.startswith(mark), lines)
    )
    return re.split(r"\.(?:\s|$)", comment)[0]
