"""`floorwalker check`: say everything that is wrong with files, each with its place."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .run import tell_notices


def check(
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE...", help="Floorplans, trials, rule sets, .asl programs; names work too."
        ),
    ],
) -> None:
    """Check floorplans, trials, rules and programs: every problem with its place; exit 1 if any."""
    faults = [fault for file in files for fault in [_fault(file)] if fault]
    for fault in faults:
        typer.echo(fault, err=True)
    if faults:
        raise typer.Exit(1)


def _fault(file: str) -> str:
    """What is wrong with a file, or an empty text after saying what was read from it."""
    try:
        typer.echo(f"{file}: {_read(file)}")
    except (ValueError, OSError) as why:
        return str(why)
    return ""


def _read(file: str) -> str:
    """What stands in a file or built-in of that name, in words."""
    import bdi
    import floorplan
    from sim import Trial, builtin_trials, load_rules

    path = Path(file)
    if path.suffix == ".asl" or file in bdi.programs():
        return _program(file)
    if file in builtin_trials():
        # A trial may be called after its floorplan: both are looked at.
        floors = f"; {_floor(floorplan.load(file))}" if file in floorplan.builtin() else ""
        return _trial(Trial.load(file)) + floors
    if path.suffix in (".yaml", ".yml") and path.exists():
        if _is_rule_set(path):
            return f"the rule set {load_rules(path).name}"
        if _is_trial(path):
            return _trial(Trial.load(path))
    return _floor(floorplan.load(file))


def _is_trial(path: Path) -> bool:
    """Whether a YAML file is a trial: it names a floorplan, or people or machines on one."""
    import floorplan

    data = floorplan.read_yaml(path, floorplan.FloorplanError).data
    return isinstance(data, dict) and not {"boundary", "image"} & set(data)


def _is_rule_set(path: Path) -> bool:
    """Whether a YAML file is a rule set: it has laws or what follows, and no floorplan."""
    import floorplan

    data = floorplan.read_yaml(path, floorplan.FloorplanError).data
    telling = {"based_on", "gantry_law", "agv_law", "notice", "gantry_disabled"}
    return isinstance(data, dict) and bool(telling & set(data)) and "floorplan" not in data


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
