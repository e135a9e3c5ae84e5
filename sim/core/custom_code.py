"""Custom code: find a definition by name, read its source, import it, report its errors."""

from __future__ import annotations

import ast
import importlib
import keyword
import re
import sys
import traceback
import warnings
from collections.abc import Callable, Container, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.machinery import BuiltinImporter, FrozenImporter
from pathlib import Path
from types import FrameType, ModuleType
from typing import Any, TypeAlias

from floorplan import InputError, UserError
from floorplan.files.problems import suggestion
from floorplan.files.reading import is_file, read_bytes
from navigation import PlanningError

from .clock import Clock

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
class CodeLocation:
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


def find_source(name: str, folder: Path, kind: Kind) -> CodeLocation:
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
    source = CodeLocation(folder.resolve(), module, attribute, file, definitions[attribute], kind)
    if not kind.written(source.definition):
        raise misfit(source)
    return source


def misfit(source: CodeLocation) -> OwnCodeError:
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


@dataclass(frozen=True)
class Parameters:
    """The names by which a class takes values when it is made, and those it can't do without."""

    names: tuple[str, ...]
    needed: tuple[str, ...]
    any_name: bool = False


def parameters(definition: ast.ClassDef) -> Parameters | None:
    """Return the parameters of a class as its source shows them; None if only a run can."""
    for node in definition.body:
        if isinstance(node, ast.FunctionDef) and node.name == "__init__":
            return None if definition.decorator_list or node.decorator_list else _of_init(node)
    if is_plain(definition):
        return None if "__new__" in methods(definition) else Parameters((), ())
    decorators = [ast.unparse(one).partition("(")[0] for one in definition.decorator_list]
    if decorators in (["dataclass"], ["dataclasses.dataclass"]) and not definition.bases:
        return _of_fields(definition)
    return None


def _of_init(node: ast.FunctionDef) -> Parameters:
    given = node.args
    by_place = [one.arg for one in (*given.posonlyargs, *given.args)]
    needed = by_place[: len(by_place) - len(given.defaults)]
    named = [one.arg for one in given.kwonlyargs]
    needed += [one for one, usual in zip(named, given.kw_defaults, strict=True) if usual is None]
    return Parameters(
        (*by_place[1:], *named),
        tuple(name for name in needed if name not in by_place[:1]),
        given.kwarg is not None,
    )


def _of_fields(definition: ast.ClassDef) -> Parameters | None:
    """Return the fields of a dataclass; None where `field()` and the like say more than a value."""
    names, needed = [], []
    for node in definition.body:
        if not (isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)):
            continue
        if isinstance(node.value, ast.Call) or re.search(
            r"\b(ClassVar|InitVar|KW_ONLY)\b", ast.unparse(node.annotation)
        ):
            return None
        names.append(node.target.id)
        if node.value is None:
            needed.append(node.target.id)
    return Parameters(tuple(names), tuple(needed))


_imported: dict[Path, dict[str, ModuleType]] = {}
"""Modules imported from the folders of trials, by their names there."""


def import_own(source: CodeLocation) -> Any:
    """Import the module of `source` and return the object there.

    It is the module in that file, whatever else of its name was imported before. `OwnCodeError`
    if it can't be imported, or if what has the name then was not defined there or is not of the
    kind that is wanted.
    """
    _refuse_names_of_python(source)
    try:
        with _looked_up_in(source.folder, _top(source.module)):
            module = importlib.import_module(source.module)
    except (Exception, SystemExit) as why:
        place = line_in(why, {str(source.file)})
        raise OwnCodeError(f"{source.name!r} can't be imported{place}: {in_words(why)}") from why
    if module.__file__ is None or Path(module.__file__).resolve() != source.file.resolve():
        raise OwnCodeError(
            f"{source.name!r} can't be imported: Python finds {source.module} in"
            f" {module.__file__} before; give yours another name, or an __init__.py"
        )
    found = getattr(module, source.attribute, None)
    if getattr(found, "__module__", None) != module.__name__:
        raise OwnCodeError(
            f"{source.name!r} is {found!r} once {source.file.name} is imported, which is not"
            " defined there"
        )
    if not source.kind.made(found):
        raise misfit(source)
    return found


@contextmanager
def supervised(clock: Clock | None = None) -> Iterator[None]:
    """Give an error that arises in an imported module, or in what it calls, the line there.

    It becomes an `OwnCodeError`, with the time of `clock`. Errors of Floorwalker's own kinds say
    themselves what is wrong, except that a `PlanningError` does not know who asked for the path.
    """
    try:
        yield
    except Exception as why:
        place = own_line(why)
        if not place or (is_ours(why) and not isinstance(why, PlanningError)):
            raise
        when = "" if clock is None else f" at t = {clock.now:g} s"
        raise OwnCodeError(f"code of your own failed{when}{place}: {in_words(why)}") from why


@contextmanager
def broken_off() -> Iterator[None]:
    """Turn a Ctrl-C that breaks off an imported module into an `OwnCodeError` with the line."""
    try:
        yield
    except KeyboardInterrupt as why:
        place = own_line(why)
        if not place:
            raise
        raise OwnCodeError(f"code of your own did not come to its end{place}") from why


def own_line(why: BaseException) -> str:
    """Return the innermost line of an imported module in which an error arose.

    As " (FILE, line N)", or nothing.
    """
    return line_in(why, _own_files())


def is_under_way(frame: FrameType | None) -> bool:
    """Return True if an imported module is at work in `frame`, or waits for what it called."""
    files = _own_files()
    while frame is not None:
        if frame.f_code.co_filename in files:
            return True
        frame = frame.f_back
    return False


def _own_files() -> set[str | None]:
    return {module.__file__ for own in _imported.values() for module in own.values()}


def _refuse_names_of_python(source: CodeLocation) -> None:
    """Refuse a module that could not be imported: Python finds its own ones first."""
    top = _top(source.module)
    if BuiltinImporter.find_spec(top) or FrozenImporter.find_spec(top):
        raise OwnCodeError(
            f"{source.name!r} can't be imported: Python itself has a module {top!r}; give yours"
            " another name"
        )


def _top(module_name: str) -> str:
    return module_name.partition(".")[0]


@contextmanager
def _looked_up_in(folder: Path, top: str) -> Iterator[None]:
    """Let `import` look into `folder` first, and know nothing from the folders of other trials.

    A module named `top` that stands elsewhere is set aside meanwhile.
    """
    for modules in _imported.values():
        for name, module in modules.items():
            if sys.modules.get(name) is module:
                del sys.modules[name]
    aside: dict[str, ModuleType] = {}
    if not _stands_in(folder, top):
        aside = {name: sys.modules.pop(name) for name in _loaded(top)}
    own = _imported.setdefault(folder, {})
    sys.modules.update({name: own[name] for name in own if _top(name) not in sys.modules})
    before = {*sys.modules}
    sys.path.insert(0, str(folder))
    importlib.invalidate_caches()
    try:
        yield
    finally:
        for name in {*sys.modules} - before:
            first = _top(name)
            if (first in own or first not in before) and _stands_in(folder, first):
                own[name] = sys.modules[name]
        sys.path.remove(str(folder))
        if aside:
            for name in _loaded(top):
                del sys.modules[name]
            sys.modules.update(aside)


def _loaded(top: str) -> list[str]:
    """Return the names of the loaded modules of the package, or the module, `top`."""
    return [name for name in sys.modules if _top(name) == top]


def _stands_in(folder: Path, top: str) -> bool:
    """Return True if the package or module that is loaded as `top` stands right in `folder`."""
    module = sys.modules.get(top)
    places = (*getattr(module, "__path__", ()), getattr(module, "__file__", None))
    return any(place and Path(place).parent.resolve() == folder for place in places)
