"""Programs from files and texts, and the check that all they call exists."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from .errors import Problem, ProgramError
from .parser import make_program, parse_clauses
from .program import (
    Achieve,
    Act,
    Body,
    BodyFormula,
    BodyTerm,
    Constraint,
    For,
    Fork,
    If,
    Place,
    PlanTerm,
    Program,
    Rule,
    Test,
    Update,
    While,
)
from .terms import And, Cons, Literal, Not, Or, Term

if TYPE_CHECKING:
    from .internal_actions import InternalAction


MAX_TEXT = 4_000_000
"""A longer program (in characters) is refused: it would take minutes to read."""

_HANDED_OVER = re.compile(r"/dev/(stdin|fd/\d+)|/proc/self/fd/\d+")
"""What a shell hands over, as for `<(command)`, is read though it is no regular file."""

_TOO_LONG = f"is longer than {MAX_TEXT:,} characters, which is more than anybody writes"


def programs() -> dict[str, Path]:
    """The built-in personalities: their names and files."""
    return dict(_personalities())


@cache
def _personalities() -> Mapping[str, Path]:
    folder = _built_in()
    return {
        path.stem: path for path in sorted(folder.glob("*.asl")) if path.name not in ("patrol.asl",)
    }


def _built_in() -> Path:
    return Path(str(files(__package__).joinpath("programs")))


def load(name: str | Path) -> Program:
    """A built-in personality by its name, or the program in a file."""
    if isinstance(name, str) and name in programs():
        return parse_file(programs()[name])
    return parse_file(name)


def parse_file(path: str | Path) -> Program:
    """Reads the program at `path`; files it includes lie in its folder or below, or are built in.

    Raises:
        ProgramError: the file cannot be read or has mistakes; all of them are told.
    """
    path = Path(path)
    source = _read(path)
    if isinstance(source, Problem):
        raise ProgramError([source])
    return _parse(source, str(path), path.parent)


def parse(source: str, name: str = "<text>", *, folder: str | Path | None = None) -> Program:
    """Reads a program from a text; `name` stands for it in messages.

    Args:
        source: AgentSpeak.
        name: what to call it.
        folder: where files it includes lie; without it only built-in ones can be.
    """
    return _parse(source, name, None if folder is None else Path(folder))


def _parse(source: str, name: str, folder: Path | None) -> Program:
    if len(source) > MAX_TEXT:
        raise ProgramError([Problem(name, 0, 0, _TOO_LONG)])

    def include(file: str, place: Place) -> tuple[str, str] | Problem:
        found = find_included(file, folder)
        if isinstance(found, str):
            return Problem(place.file, place.line, place.column, found)
        text = _read(found)
        if isinstance(text, Problem):
            return Problem(place.file, place.line, place.column, f"{found} {text.message}")
        return text, str(found)

    clauses, problems = parse_clauses(source, name, include)
    if problems:
        raise ProgramError(problems)
    return make_program(clauses, name, folder)


def find_included(name: str, folder: Path | None) -> Path | str:
    """The file an include means, or why there is none."""
    try:
        return _find_included(name, folder)
    except (OSError, ValueError):
        return f"'{name}' is no name of a file"


def _find_included(name: str, folder: Path | None) -> Path | str:
    if folder is not None:
        inside = folder.resolve()
        path = (inside / name).resolve()
        if not path.is_relative_to(inside):
            return f"'{name}' is outside the program's folder {folder}"
        if path.is_file():
            return path
    if name in {file.name for file in _built_in().iterdir()}:
        return _built_in() / name
    where = "and none is built in" if folder is None else f"in {folder}, and none is built in"
    return f"there is no file '{name}' {where}"


def _read(path: Path) -> str | Problem:
    """The text of the regular file at `path`, or of what a shell hands over."""
    try:
        if not (path.is_file() or _HANDED_OVER.fullmatch(str(path))) and path.exists():
            return Problem(str(path), 0, 0, "is no regular file")
        with path.open(encoding="utf-8") as file:
            text = file.read(MAX_TEXT + 1)
    except FileNotFoundError:
        return Problem(str(path), 0, 0, "there is no such file")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        return Problem(str(path), 0, 0, f"cannot be read: {reason}")
    return Problem(str(path), 0, 0, _TOO_LONG) if len(text) > MAX_TEXT else text


# ---- what a program calls


def check_actions(program: Program, actions: Mapping[str, InternalAction]) -> None:
    """Raises ProgramError for internal actions that do not exist or stand where they cannot."""
    problems: list[Problem] = []
    for place, action, in_context in _calls(program):
        name = action.functor
        if name not in actions:
            near = get_close_matches(name, actions, n=1)
            hint = f"; did you mean {near[0]}?" if near else ""
            message = f"there is no internal action {name}{hint}"
        elif in_context and not actions[name].in_context:
            message = f"{name} cannot be used in a context or query"
        else:
            continue
        problem = Problem(place.file, place.line, place.column, message)
        if problem not in problems:
            problems.append(problem)
    if problems:
        raise ProgramError(problems)


def _calls(program: Program) -> Iterator[tuple[Place, Literal, bool]]:
    for clause in program.beliefs:
        if isinstance(clause, Rule):
            yield from ((clause.place, call, True) for call in _in_formula(clause.body))
    for plan in program.plans:
        yield from ((plan.place, call, True) for call in _in_formula(plan.context))
        yield from _in_body(plan.body)


def _in_body(body: Body) -> Iterator[tuple[Place, Literal, bool]]:
    for step in body:
        yield from _in_step(step)


def _in_step(step: BodyFormula) -> Iterator[tuple[Place, Literal, bool]]:
    if isinstance(step, Act):
        if isinstance(step.action, Literal) and step.action.is_internal_action:
            yield step.place, step.action, False
            for arg in step.action.args:
                yield from ((step.place, call, True) for call in _in_formula(arg))
    elif isinstance(step, Test):
        yield from ((step.place, call, True) for call in _in_formula(step.formula))
    elif isinstance(step, If):
        yield from ((step.place, call, True) for call in _in_formula(step.condition))
        yield from _in_body(step.then)
        yield from _in_body(step.otherwise)
    elif isinstance(step, While):
        yield from ((step.place, call, True) for call in _in_formula(step.condition))
        yield from _in_body(step.body)
    elif isinstance(step, For):
        yield from ((step.place, call, True) for call in _in_formula(step.generator))
        yield from _in_body(step.body)
    elif isinstance(step, Fork):
        for branch in step.branches:
            yield from _in_body(branch)
    elif isinstance(step, Achieve | Update | Constraint):
        return


def _in_formula(formula: Term) -> Iterator[Literal]:
    pending = [formula]
    while pending:
        part = pending.pop()
        if isinstance(part, Literal) and part.is_internal_action:
            yield part
            pending.extend(part.args)
        elif isinstance(part, And | Or):
            pending.extend((part.right, part.left))
        elif isinstance(part, Not):
            pending.append(part.formula)
        elif isinstance(part, Cons):
            pending.extend(e for e in part if isinstance(e, PlanTerm))
        elif isinstance(part, PlanTerm):
            yield from (call for _, call, _ in _in_body(part.plan.body))
        elif isinstance(part, BodyTerm):
            yield from (call for _, call, _ in _in_body(part.body))
