"""Python of the user's own as it is written: found beside the file that names it, and never run."""

from __future__ import annotations

import ast
import keyword
import traceback
import warnings
from collections.abc import Callable, Container, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from floorplan import InputError, UserError, is_file, read_bytes, suggestion

Definition: TypeAlias = "ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef"

REFUSED = "code of your own is refused here (own_code: false, --no-own-code)"
"""The message where files may name nothing but built-in things."""


DEFECT = "a defect of Floorwalker, not a mistake of yours; please report it"
"""The words for an error that no input may cause."""


class OwnCodeError(UserError):
    """Code of the user's own that can't be found, is not of the kind that is wanted, or fails."""


@dataclass(frozen=True)
class Kind:
    """A kind of code that files name.

    `words` say what it has to be. `written` is False for a definition whose source shows that it
    is something else, `made` for an object that is.
    """

    words: str
    written: Callable[[Definition], bool]
    made: Callable[[Any], bool]


@dataclass(frozen=True)
class Source:
    """The place of `module`:`attribute` below `folder`: its file, and its definition there."""

    folder: Path
    module: str
    attribute: str
    file: Path
    definition: Definition
    kind: Kind

    @property
    def name(self) -> str:
        """Its name as files have it."""
        return f"{self.module}:{self.attribute}"


def find_source(name: str, folder: Path, kind: Kind) -> Source:
    """Return the definition of `package.module:name`, a module or package right in `folder`.

    Nothing is imported. `OwnCodeError` if there is no such file, if it can't be parsed, or if it
    does not define a class or function of that name, of that `kind`, at its top level.
    """
    module, colon, attribute = name.partition(":")
    parts = module.split(".")
    if not (colon and all(map(_is_name, [*parts, attribute]))):
        raise OwnCodeError(f"{name!r} is not of the form package.module:name")
    path = folder.resolve().joinpath(*parts)
    files = (path / "__init__.py", path.parent / f"{path.name}.py")
    file = next(filter(is_file, files), None)
    if file is None:
        hint = "code of your own stands beside the file that names it"
        if parts[-1] == "py":
            hint = f"a module is named without its ending: {'.'.join(parts[:-1])}:{attribute}"
        raise OwnCodeError(
            f"{name!r} can't be found: there is no {'/'.join(parts)}.py in {folder.resolve()};"
            f" {hint}"
        )
    definitions = definitions_in(name, file)
    if attribute not in definitions:
        hint = f"; {suggestion(attribute, definitions)}" if definitions else ""
        raise OwnCodeError(
            f"{name!r} can't be found: {file.name} defines no class or function {attribute!r} at"
            f" its top level{hint}"
        )
    source = Source(folder.resolve(), module, attribute, file, definitions[attribute], kind)
    if not kind.written(source.definition):
        raise misfit(source)
    return source


def misfit(source: Source) -> OwnCodeError:
    """Return the error that something is not of its kind."""
    place = f"{source.file.name}, line {source.definition.lineno}"
    return OwnCodeError(f"{source.name!r} ({place}) is no {source.kind.words}")


def in_words(why: BaseException) -> str:
    """Return the error's text with its type: a `KeyError` says no more than the key."""
    return f"{type(why).__name__}: {why}".removesuffix(": ")


def is_ours(why: BaseException) -> bool:
    """Return True if an error is of one of Floorwalker's own kinds."""
    return type(why).__module__.partition(".")[0] in ("floorplan", "navigation", "bdi", "sim")


def line_in(why: BaseException, files: Container[str | None]) -> str:
    """Return the innermost line of some files in which an error arose.

    As " (FILE, line N)", or nothing.
    """
    frames = traceback.extract_tb(why.__traceback__)
    places = [(frame.filename, frame.lineno) for frame in frames]
    if isinstance(why, SyntaxError) and why.filename is not None:
        places.append((why.filename, why.lineno))
    inside = [(file, line) for file, line in places if file in files]
    return f" ({Path(inside[-1][0]).name}, line {inside[-1][1]})" if inside else ""


def is_plain(definition: ast.ClassDef) -> bool:
    """Return True if a class has only what its body says: no base, no metaclass, no decorator."""
    return not (definition.bases or definition.keywords or definition.decorator_list)


def is_derived(definition: Definition) -> bool:
    """Return True for a class with a base: which one its source does not show."""
    return isinstance(definition, ast.ClassDef) and bool(definition.bases)


def methods(definition: ast.ClassDef) -> set[str]:
    """Return the names that the body of a class binds with `def` or `=`."""
    bound = {node.name for node in definition.body if isinstance(node, ast.FunctionDef)}
    for node in definition.body:
        if isinstance(node, ast.Assign):
            bound |= {target.id for target in node.targets if isinstance(target, ast.Name)}
    return bound


def _is_name(text: str) -> bool:
    return text.isidentifier() and not keyword.iskeyword(text)


def definitions_in(name: str, file: Path) -> dict[str, Definition]:
    """Return the classes and functions of a file; `OwnCodeError` if it can't be read."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # they are shown when the file is imported
            tree = ast.parse(read_bytes(file, InputError), filename=str(file))
        return {found.name: found for found in _defined(tree.body)}
    except InputError as why:
        raise OwnCodeError(f"{name!r} can't be read: {why}") from why
    except (SyntaxError, ValueError, RecursionError, MemoryError) as why:
        raise OwnCodeError(
            f"{name!r} can't be read{line_in(why, {str(file)})}: {in_words(why)}"
        ) from why


def _defined(body: list[ast.stmt]) -> Iterator[Definition]:
    """Yield the classes and functions of a module, also those under `if`, `try` and the like."""
    for node in body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield node
            continue
        for block in ("body", "orelse", "finalbody"):
            yield from _defined(getattr(node, block, []))
        for handler in getattr(node, "handlers", []):
            yield from _defined(handler.body)
