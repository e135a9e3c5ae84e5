"""Custom code: find a definition by its name, import it, judge it, and locate its errors."""

from __future__ import annotations

import ast
import importlib
import inspect
import keyword
import sys
import traceback
import warnings
from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
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
    """Custom code that cannot be found, is of the wrong kind, or fails."""


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of code that files name as `package.module:name`.

    `noun` names it in messages and `words` say what it has to be. `accepts` judges the imported
    object. `builtin` are those that have a plain name, and `error` is raised for all faults.
    """

    noun: str
    words: str
    accepts: Callable[[Any], bool]
    error: type[UserError] = OwnCodeError
    builtin: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class CustomCode:
    """The module `module` in or below `folder`, or its definition `attribute` in a `line` of it.

    Nothing is imported before `load`. Its methods raise the error of its kind.
    """

    folder: Path
    module: str
    file: Path
    kind: Kind
    attribute: str = ""
    line: int = 1

    @property
    def name(self) -> str:
        """Its name as files have it."""
        return f"{self.module}:{self.attribute}" if self.attribute else self.module

    def definitions(self) -> dict[str, Definition]:
        """Return the classes and functions at the top level of the file."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # they are shown when the file is imported
                tree = ast.parse(read_bytes(self.file, InputError), filename=str(self.file))
            return {found.name: found for found in _defined(tree.body)}
        except InputError as why:
            raise self._fault(f"can't be read: {why}") from why
        except (SyntaxError, ValueError, RecursionError, MemoryError) as why:
            place = line_in(why, {str(self.file)})
            raise self._fault(f"can't be read{place}: {in_words(why)}") from why

    def load(self) -> Any:
        """Import the module, and return it or the object with the name `attribute` there."""
        try:
            with _importing_from(self.folder, self.module.partition(".")[0]):
                module = importlib.import_module(self.module)
        except (Exception, SystemExit) as why:
            place = line_in(why, {str(self.file)})
            raise self._fault(f"can't be imported{place}: {in_words(why)}") from why
        if module.__file__ is None or Path(module.__file__).resolve() != self.file.resolve():
            raise self._fault(
                f"can't be imported: Python finds {self.module} in {module.__file__} before; give"
                " yours another name, or an __init__.py"
            )
        if not self.attribute:
            return module
        found = getattr(module, self.attribute, None)
        if getattr(found, "__module__", None) != self.module:
            raise self._fault(
                f"is {found!r} once {self.file.name} is imported, which is not defined there"
            )
        if not self.kind.accepts(found):
            raise self._fault(f"({self.file.name}, line {self.line}) is no {self.kind.words}")
        return found

    def _fault(self, message: str) -> UserError:
        return _fault(self.kind, self.name, message)


@dataclass(frozen=True)
class CodeFolder:
    """Folder in which custom code stands; unless it is `allowed` there, all of it is refused."""

    path: Path = Path()
    allowed: bool = True

    def find(self, name: str, kind: Kind) -> CustomCode:
        """Return the definition of `package.module:name`, a module or package right in the folder.

        Nothing is imported. The error of the `kind` is raised if there is no such file, if it
        cannot be parsed, if it defines no class or function of that name at its top level, or if
        it is refused.
        """
        module, colon, attribute = name.partition(":")
        if not colon and kind.builtin:
            raise kind.error(
                f"no {kind.noun} is called {name!r}; {suggestion(name, kind.builtin)};"
                " your own is package.module:name"
            )
        if not (colon and _is_name(attribute)):
            raise _fault(kind, name, "is not of the form package.module:name")
        found = self._located(name, module, attribute, kind)
        definitions = found.definitions()
        if attribute not in definitions:
            hint = f"; {suggestion(attribute, definitions)}" if definitions else ""
            raise _fault(
                kind,
                name,
                f"can't be found: {found.file.name} defines no class or function {attribute!r} at"
                f" its top level{hint}",
            )
        return replace(found, line=definitions[attribute].lineno)

    def find_module(self, name: str, kind: Kind) -> CustomCode:
        """Return the module called `name` in the folder. Errors are as of `find`."""
        return self._located(name, name, "", kind)

    def _located(self, name: str, module: str, attribute: str, kind: Kind) -> CustomCode:
        parts = module.split(".")
        if not all(map(_is_name, parts)):
            raise _fault(kind, name, "is not of the form package.module:name")
        if not self.allowed:
            raise kind.error(f"the {kind.noun} {name!r}: {REFUSED}")
        folder = self.path.resolve()
        path = folder.joinpath(*parts)
        file = next(filter(is_file, (path / "__init__.py", path.parent / f"{path.name}.py")), None)
        if file is None:
            hint = "code of your own stands beside the file that names it"
            if parts[-1] == "py":
                hint = f"a module is named without its ending: {'.'.join(parts[:-1])}:{attribute}"
            where = f"there is no {'/'.join(parts)}.py in {folder}"
            raise _fault(kind, name, f"can't be found: {where}; {hint}")
        if parts[0] in sys.stdlib_module_names:
            message = f"Python itself has a module {parts[0]!r}; give yours another name"
            raise _fault(kind, name, f"can't be imported: {message}")
        return CustomCode(folder=folder, module=module, file=file, kind=kind, attribute=attribute)


def _fault(kind: Kind, name: str, message: str) -> UserError:
    return kind.error(f"the {kind.noun} {name!r} {message}")


def argument_fault(found: Any, given: Mapping[str, Any]) -> str:
    """Return why a class or function cannot be called with these arguments, or an empty text."""
    try:
        signature = inspect.signature(found)
    except (TypeError, ValueError):  # written in C
        return ""
    try:
        signature.bind(**given)
    except TypeError as why:
        return f"{why}; it takes {signature}"
    return ""


def _is_name(text: str) -> bool:
    return text.isidentifier() and not keyword.iskeyword(text)


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


_imported: dict[Path, dict[str, ModuleType]] = {}
"""Modules imported from the folders of trials, by their names there."""


@contextmanager
def _importing_from(folder: Path, top: str) -> Iterator[None]:
    """Let `import` look into `folder` first, and forget modules of the folders of other trials.

    They keep their plain names, by which other processes find the classes of pickled objects.
    A module or package `top` that was imported from elsewhere is set aside meanwhile.
    """
    for modules in _imported.values():
        for name, module in modules.items():
            if sys.modules.get(name) is module:
                del sys.modules[name]
    elsewhere = {} if _stands_in(folder, top) else _modules_of(top)
    for name in elsewhere:
        del sys.modules[name]
    own = _imported.setdefault(folder, {})
    sys.modules.update({name: own[name] for name in own if name not in sys.modules})
    before = {*sys.modules}
    sys.path.insert(0, str(folder))
    importlib.invalidate_caches()
    try:
        yield
    finally:
        sys.path.remove(str(folder))
        for name in {*sys.modules} - before:
            if _stands_in(folder, name.partition(".")[0]):
                own[name] = sys.modules[name]
        if elsewhere:
            for name in _modules_of(top):
                del sys.modules[name]
            sys.modules.update(elsewhere)


def _modules_of(top: str) -> dict[str, ModuleType]:
    """Return the loaded module or package `top` and what is loaded of it, by their names."""
    return {name: module for name, module in sys.modules.items() if name.partition(".")[0] == top}


def _stands_in(folder: Path, top: str) -> bool:
    """Return True if the package or module that is loaded as `top` stands right in `folder`."""
    module = sys.modules.get(top)
    places = (*getattr(module, "__path__", ()), getattr(module, "__file__", None))
    return any(place and Path(place).parent.resolve() == folder for place in places)


# ---- errors of custom code


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


def own_line(why: BaseException) -> str:
    """Return the innermost line of custom code in which an error arose, as of `line_in`."""
    return line_in(why, _own_files())


@contextmanager
def supervised(clock: Clock | None = None) -> Iterator[None]:
    """Raise an `OwnCodeError` with line and time for errors that arise in custom code.

    Errors of Floorwalker's own kinds say themselves what is wrong, except that a `PlanningError`
    does not know who asked for the path.
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
    """Raise an `OwnCodeError` with the line where Ctrl-C interrupts custom code."""
    try:
        yield
    except KeyboardInterrupt as why:
        place = own_line(why)
        if not place:
            raise
        raise OwnCodeError(f"your code was interrupted{place}") from why


def is_under_way(frame: FrameType | None) -> bool:
    """Return True if custom code runs in `frame`, or waits for what it called."""
    files = _own_files()
    while frame is not None:
        if frame.f_code.co_filename in files:
            return True
        frame = frame.f_back
    return False


def _own_files() -> set[str | None]:
    return {module.__file__ for own in _imported.values() for module in own.values()}
