"""`floorwalker check`: say everything that is wrong with files, each with its place."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from . import completion
from .run import tell_notices

RULE_KEYS = {"based_on", "gantry_law", "agv_law", "notice", "gantry_disabled"}
"""What tells a file with a rule set."""


def check(
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE...",
            help="Floorplans, trials, studies, rule sets, .asl programs; names work too.",
            autocompletion=completion.checked,
        ),
    ],
) -> None:
    """Check files of every kind: all their problems, each with its place; exit 1 if any."""
    faults = [fault for file in files for fault in [_fault(file)] if fault]
    for fault in faults:
        typer.echo(fault, err=True)
    if faults:
        raise typer.Exit(1)


def _fault(file: str) -> str:
    """What is wrong with a file, or an empty text after saying what was read from it."""
    try:
        content = _read(file)
    except (ValueError, OSError) as why:
        return str(why)
    typer.echo(f"{file}: {content}")
    return ""


def _read(file: str) -> str:
    """What stands in a file or built-in of that name, in words."""
    import bdi
    import floorplan
    from sim import Study, Trial, builtin_trials, load_rules

    path = Path(file)
    if path.suffix == ".asl" or file in bdi.programs():
        return _program(file)
    if file in builtin_trials():
        # A trial may be called after its floorplan: both are looked at.
        floors = f"; {_floor(floorplan.load(file))}" if file in floorplan.builtin() else ""
        return _trial(Trial.load(file)) + floors
    if path.suffix in (".yaml", ".yml") and path.exists():
        keys = _keys(path)
        if "trials" in keys:
            return _study(Study.load(path))
        if keys & RULE_KEYS and "floorplan" not in keys:
            return f"the rule set {load_rules(path).name}"
        if not {"boundary", "image"} & keys:
            return _trial(Trial.load(path))
    return _floor(floorplan.load(file))


def _keys(path: Path) -> set[str]:
    """The outermost keys of a YAML file, which tell what is in it."""
    import floorplan

    data = floorplan.read_yaml(path, floorplan.FloorplanError).data
    return set(data) if isinstance(data, dict) else set()


def _study(study: object) -> str:
    from sim import Study

    assert isinstance(study, Study)
    trials = _number(len(study.trials), "trial")
    return f"a study of {trials}, {_number(len(study), 'row')}"


def _program(file: str) -> str:
    import bdi

    program = bdi.load(file)
    return f"a program of {_number(len(program.plans), 'plan')}"


def _trial(trial: object) -> str:
    from sim import Trial

    assert isinstance(trial, Trial)
    tell_notices(trial)
    people = ", ".join(f"{p.name} ({Path(p.personality).stem})" for p in trial.people) or "nobody"
    work = f" and {_number(len(trial.workload.orders), 'order')}" if trial.workload else ""
    upto = "up to " if trial.until_submitted else ""
    return f"a trial of {upto}{trial.duration:g} s on {trial.floorplan.name} with {people}{work}"


def _floor(plan: object) -> str:
    from floorplan import Floorplan

    assert isinstance(plan, Floorplan)
    west, south, east, north = plan.boundary.bounds
    things = [
        _number(len(plan.obstacles), "obstacle"),
        _number(len(plan.stations), "station"),
        _number(len(plan.lanes), "AGV"),
    ]
    return (
        f"a floorplan of {east - west:g} m × {north - south:g} m with {', '.join(things)}"
        f" and {'a' if plan.gantry else 'no'} gantry"
    )


def _number(count: int, thing: str) -> str:
    return f"{count} {thing}" if count == 1 else f"{count} {thing}s"
