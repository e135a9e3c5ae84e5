"""`floorwalker check`, `convert` and `list`."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .arguments import NoOwnCode, complete_checked, complete_floor
from .terminal import print_floor_notices, print_notices, say

if TYPE_CHECKING:
    from bdi import ProgramProblem
    from floorplan import Floorplan

    from .. import Trial
    from ..machines.kinds import ShortDistance, ShortLaw


def check(
    files: Annotated[
        list[str],
        typer.Argument(
            metavar="FILE...",
            help="Floorplans, trials, studies, rule sets or .asl programs: files or names.",
            autocompletion=complete_checked,
        ),
    ],
    no_own_code: NoOwnCode = False,
) -> None:
    """Check files and list all their problems with their locations.

    The exit code is 1 if there are errors. Custom Python code is not imported.
    """
    own_code = not no_own_code
    faults = [fault for file in files for fault in [_fault(file, own_code)] if fault]
    for fault in faults:
        say(fault, err=True)
    if faults:
        raise typer.Exit(1)


def _fault(file: str, own_code: bool) -> str:
    """Return the faults of a file, or an empty text after printing its contents in words."""
    import bdi
    from floorplan import UserError

    try:
        content = _read(file, own_code)
    except (UserError, bdi.ProgramError, OSError) as why:
        return str(why)
    say(f"{file}: {content}")
    return ""


def _read(file: str, own_code: bool) -> str:
    """Return the contents of a file or built-in of that name, in words."""
    import bdi
    import floorplan

    from ..trials.rules_file import RuleForm, load_rules
    from ..trials.trial import Trial
    from .sources import outermost_keys

    path = Path(file)
    if path.suffix == ".asl" or file in bdi.programs():
        return _program(file)
    if built_in := list(_built_in(file)):
        return "; ".join(built_in)
    if path.suffix in (".yaml", ".yml") and path.exists():
        keys = outermost_keys(path)
        if "trials" in keys:
            return _study(path, own_code)
        if {"boundary", "base", "image"} & keys:
            return _floor(floorplan.load(path))
        if keys & {*RuleForm.model_fields} - {"name", "source"} and "floorplan" not in keys:
            return f"the rule set {load_rules(path, own_code=own_code).name}"
        return _trial(Trial.load(path, own_code=own_code), file)
    return _floor(floorplan.load(file))


def _built_in(name: str) -> Iterator[str]:
    """Return the built-ins of that name. Trials, floorplans and rule sets may share a name."""
    import floorplan

    from ..core.rules import RULE_SETS
    from ..trials.trial import Trial, builtin_trials

    if name in builtin_trials():
        yield _trial(Trial.load(name), name)
    if name in floorplan.builtin():
        yield _floor(floorplan.load(name))
    if name in RULE_SETS:
        yield f"the rule set {name}"


def _study(path: Path, own_code: bool) -> str:
    from ..studies.design import Study

    study = Study.load(path, own_code=own_code)
    trials = _number(len(study.trials), "trial")
    if study.repeat > 1 and not study.random:
        message = f"notice: nothing is drawn in `random`, so the {study.repeat} repeats of a"
        say(f"{path}: {message} combination differ only in what trials draw by seed", err=True)
    return f"a study of {trials}, {_number(len(study), 'row')}"


def _program(file: str) -> str:
    import bdi

    from ..core.custom_code import CodeFolder
    from ..people.programs import load_program

    program = load_program(file, CodeFolder())
    assert program is not None  # external agents have no program to check
    _print_doubts(bdi.doubts(program))
    return f"a program of {_number(len(program.plans), 'plan')}"


def _trial(trial: Trial, file: str) -> str:
    from ..people.actions import doubts_in
    from ..trials.names import in_words, machines_in_words

    print_floor_notices(trial.floorplan)
    print_notices(trial)
    _warn_of_short_laws(trial, file)
    _print_doubts(doubts_in(trial))
    machines = machines_in_words(trial)
    bodies = in_words(trial) + (f" and the {machines}" if machines else "")
    work = f" and {_number(len(trial.workload.ids), 'order')}" if trial.workload else ""
    upto = "up to " if trial.until_submitted else ""
    return f"a trial of {upto}{trial.duration:g} s on {trial.floorplan.name} with {bodies}{work}"


def _print_doubts(doubts: Iterable[ProgramProblem]) -> None:
    """Print the warnings about programs."""
    for doubt in doubts:
        say(str(doubt), err=True)


def _warn_of_short_laws(trial: Trial, file: str) -> None:
    """Print warnings about rule sets that assume shorter stops than machines may need."""
    import floorplan
    from floorplan.files.documents import read_yaml

    from ..machines.kinds import in_words, short_laws

    short_ones = [short for short in short_laws(trial) if not _scores(trial, short)]
    if not short_ones:
        return
    message = f"warning: the law's stopping distance is shorter than that of {in_words(short_ones)}"
    problem = floorplan.Problem(message, "rules")
    path = Path(file)
    if path.suffix in (".yaml", ".yml") and path.exists():
        document = read_yaml(path, floorplan.FloorplanError)
        laws = {("rules", short.law) for short in short_ones}
        place = laws.pop() if len(laws) == 1 and laws <= document.lines.keys() else ("rules",)
        if place in document.lines:
            problem = document.problem(message, *place)
    say(f"{file}: {problem}", err=True)


def _scores(trial: Trial, short: ShortLaw | ShortDistance) -> bool:
    """Return whether a law is the competition's for its own machine: a score, not a protection."""
    from ..core.rules import ARIAC2023, PAPER

    plan, rules = trial.floorplan, trial.rules
    return (
        plan.name == ARIAC2023.name
        and rules.machine != "stop"
        and short.machine in {"gantry", *(lane.name for lane in plan.lanes)}
        and getattr(rules, short.law, None) in (PAPER.gantry_law, ARIAC2023.agv_law)
    )


def _floor(plan: Floorplan) -> str:
    print_floor_notices(plan)
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


def convert(
    source: Annotated[
        str,
        typer.Argument(
            metavar="IN", help="Floorplan: a name or a file.", autocompletion=complete_floor
        ),
    ],
    target: Annotated[
        Path,
        typer.Argument(
            metavar="OUT", help="File that ends in .yaml, .wkt, .geojson, or .pgm (a ROS map)."
        ),
    ],
    resolution: Annotated[
        float | None,
        typer.Option(help="Metres per cell of a ROS map (default: 0.05)."),
    ] = None,
) -> None:
    """Convert a floorplan to the format of OUT. With --resolution, a .yaml file is a ROS map."""
    import floorplan
    from floorplan.formats import OF_SUFFIX
    from floorplan.formats.ros_map import map_files

    plan = floorplan.load(source)
    print_floor_notices(plan)
    suffix = ".pgm" if resolution is not None else target.suffix.lower()
    files = map_files(target) if suffix == ".pgm" else (target,)
    written = sorted(files, key=lambda file: file != target)  # OUT is first
    if Path(source).exists():
        for one in written:
            if one.exists() and one.samefile(source):
                raise floorplan.UserError(f"{target}: {one} would replace IN; choose another name")
    plan.save(target, resolution=resolution)
    if lost := OF_SUFFIX[suffix].lost(plan):
        say(f"warning: {target} cannot contain: {', '.join(lost)}", err=True)
    say(f"Wrote {' and '.join(map(str, written))}")


SECTIONS = (
    *("floorplans", "trials", "planners", "personalities", "controllers", "rule sets"),
    "figures",
)
"""Sections of `floorwalker list`. The last one is printed only if it is named."""


def list_all(
    section: Annotated[
        str | None,
        typer.Argument(help=f"One of {', '.join(SECTIONS)}.", autocompletion=lambda: [*SECTIONS]),
    ] = None,
) -> None:
    """List floorplans, trials, planners, personalities, gantry controllers and rule sets.

    `list figures` lists the figures of runs that trials can expect and studies can compare.
    """
    import bdi
    import floorplan
    import navigation

    from ..core.rules import RULE_SETS
    from ..machines.gantry.controllers import CONTROLLERS
    from ..record.figures import FIGURES
    from ..trials.trial import BUILT_IN, builtin_trials

    if section is not None and section not in SECTIONS:
        raise typer.BadParameter(f"must be one of {', '.join(SECTIONS)}, not {section!r}")
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
        "figures": {
            path: ", ".join(filter(None, (figure.meaning, figure.unit)))
            for path, figure in FIGURES.items()
            if figure.form not in ("text", "parts")
        },
    }
    shown = {name: sections[name] for name in ([section] if section else SECTIONS[:-1])}
    width = max(len(name) for entries in shown.values() for name in entries)
    for title, entries in shown.items():
        say(title)
        for name, summary in entries.items():
            say(f"  {name:<{width}}  {summary}".rstrip())


def _opening(file: Path, mark: str) -> str:
    """Return the first sentence of the comment at the begin of a file, marked by `mark`."""
    lines = file.read_text(encoding="utf-8").splitlines()
    comment = " ".join(
        line.removeprefix(mark).strip()
        for line in itertools.takewhile(lambda line: line.startswith(mark), lines)
    )
    return re.split(r"\.(?:\s|$)", comment)[0]
