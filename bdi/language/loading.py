"""Programs from files and texts."""

from __future__ import annotations

import re
from functools import cache
from importlib.resources import files
from pathlib import Path

from ..errors import Problem, ProgramError
from .builder import Directive
from .parser import read_clauses
from .program import Belief, Clause, Goal, Plan, Program, Rule

MAX_TEXT = 4_000_000
"""Length of the longest program that is read (characters); it takes about a minute."""

_HANDED_OVER = re.compile(r"/dev/(stdin|fd/\d+)|/proc/self/fd/\d+")
"""Files that a shell passes, as for `<(command)`: read though they are not regular files."""

_TOO_LONG = f"is longer than {MAX_TEXT:,} characters, the most that is read"


def programs() -> dict[str, Path]:
    """Return the built-in personalities: their names and files."""
    return {path.stem: path for name, path in _built_in().items() if name != "patrol.asl"}


@cache
def _built_in() -> dict[str, Path]:
    """Return the programs in the package, by file name."""
    folder = Path(str(files("bdi").joinpath("programs")))
    return {path.name: path for path in sorted(folder.glob("*.asl"))}


def load(name: str | Path) -> Program:
    """Return the built-in personality called `name`, or the program in the file of that name.

    Raises:
        ProgramError: the program cannot be read or has mistakes.
    """
    return parse_file(programs().get(name, name) if isinstance(name, str) else name)


def parse_file(path: str | Path) -> Program:
    """Read the program at `path`; files it includes are in its folder, below it, or built in.

    Raises:
        ProgramError: the file cannot be read or has mistakes; it has all of them.
    """
    path = Path(path)
    source = _read(path)
    if isinstance(source, Problem):
        raise ProgramError([source])
    return _parse(source, str(path), path.parent)


def parse(source: str, name: str = "<text>", *, folder: str | Path | None = None) -> Program:
    """Read a program from a text.

    Args:
        source: AgentSpeak.
        name: name of the text in messages.
        folder: folder of the files it includes; without it only built-in ones are found.

    Raises:
        ProgramError: the text has mistakes; it has all of them.
    """
    return _parse(source, name, None if folder is None else Path(folder))


def _parse(source: str, name: str, folder: Path | None) -> Program:
    if len(source) > MAX_TEXT:
        raise ProgramError([Problem(name, 0, 0, _TOO_LONG)])
    found, problems = _read_all(source, name, folder, ())
    if problems:
        raise ProgramError(problems)
    return Program(
        name,
        tuple(c for c in found if isinstance(c, Belief | Rule)),
        tuple(c for c in found if isinstance(c, Goal)),
        tuple(c for c in found if isinstance(c, Plan)),
        folder,
    )


def _read_all(
    source: str, file: str, folder: Path | None, including: tuple[str, ...]
) -> tuple[list[Clause], list[Problem]]:
    """Return the clauses of a text, those of included files in their places, and all problems."""
    clauses, wrong = read_clauses(source, file)
    problems = list(wrong)
    result: list[Clause] = []
    for clause in clauses:
        if not isinstance(clause, Directive):
            result.append(clause)
            continue
        opened = _open_included(clause, folder, (*including, file))
        if isinstance(opened, str):
            problems.append(clause.place.problem(opened))
            continue
        more, more_wrong = _read_all(*opened, folder, (*including, file))
        result.extend(more)
        problems.extend(more_wrong)
    return result, sorted(problems, key=lambda p: (p.file != file, p.file, p.line, p.column))


def _open_included(
    directive: Directive, folder: Path | None, including: tuple[str, ...]
) -> tuple[str, str] | str:
    """Return the text and the path of an included file, or the reason why there is none."""
    if directive.name != "include":
        return f"there is no directive '{directive.name}'; the one there is is include"
    if len(directive.args) != 1 or not isinstance(directive.args[0], str):
        return 'include takes the name of a file: { include("patrol.asl") }'
    found = find_included(directive.args[0], folder)
    if isinstance(found, str):
        return found
    text = _read(found)
    if isinstance(text, Problem):
        return f"{found} {text.message}"
    if str(found) in including:
        return f"{directive.args[0]} includes itself"
    return text, str(found)


def find_included(name: str, folder: Path | None) -> Path | str:
    """Return the file that an inclusion names, or the reason why there is none."""
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
    if name in _built_in():
        return _built_in()[name]
    where = "and none is built in" if folder is None else f"in {folder}, and none is built in"
    return f"there is no file '{name}' {where}"


def _read(path: Path) -> str | Problem:
    """Return the text of a file that is regular or passed by a shell."""
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
