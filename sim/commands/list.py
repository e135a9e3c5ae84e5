"""`floorwalker list`: everything that comes with Floorwalker, by name."""

from __future__ import annotations

import itertools
from pathlib import Path

from .consoles import say


def list_all() -> None:
    """List floorplans, trials, planners, personalities, controllers and rule sets."""
    import bdi
    import floorplan
    import navigation
    from sim import CONTROLLERS, RULE_SETS, builtin_trials

    sections = {
        "floorplans": {name: floorplan.load(name).title for name in floorplan.builtin()},
        "trials": dict.fromkeys(builtin_trials(), ""),
        "planners": {info.name: info.summary for info in navigation.planners()},
        "personalities": {name: _opening(path) for name, path in bdi.programs().items()},
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


def _opening(program: Path) -> str:
    """Return the first sentence of the comment that a personality's file begins with."""
    lines = program.read_text(encoding="utf-8").splitlines()
    comment = " ".join(
        line.removeprefix("//").strip()
        for line in itertools.takewhile(lambda line: line.startswith("//"), lines)
    )
    _, _, who = comment.partition(": ")
    return who.partition(".")[0]
