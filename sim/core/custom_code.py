"""Custom code: find definitions by name, import them, and locate their errors."""

from __future__ import annotations

import ast
import importlib
import inspect
import keyword
import sys
import traceback
import warnings
from collections.abc import Callable, Collection, Container, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from contextvars import ContextVar
from dataclasses import field, replace
from functools import partial
from pathlib import Path
from types import FrameType, ModuleType
from typing import Any, TypeAlias

from floorplan import InputError, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.problems import suggestion
from floorplan.files.reading import is_file, read_bytes
from navigation import PlanningError

from .clock import Clock

Definition: TypeAlias = "ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef"

REFUSED = "code of your own is refused here (own_code: false, --no-own-code)"
"""Message for custom code in files that may not name any."""

DEFECT = "a defect of Floorwalker, not a mistake of yours; please report it"
"""Words for errors that no input may cause."""


class OwnCodeError(UserError):
    """Custom code that cannot be found, is of the wrong kind, or fails."""


@dataclass(frozen=True, kw_only=True)
class Kind:
    """Kind of code that files name as `package.module:name`.

    `noun` and `words` describe it in messages. `accepts` tests the imported object. `builtin` has
    built-in objects with plain names, and `error` is raised for all faults.
    """

    noun: str
    words: str
    accepts: Callable[[Any], bool]
    error: type[UserError] = OwnCodeError
    builtin: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class CustomCode:
    """Module in or below `folder`, or its definition `attribute` in a `line` of it.

    It is imported by `load`. Methods raise the error of its kind.
    """

    folder: Path
    module: str
    file: Path
    kind: Kind
    attribute: str = ""
    line: int = 1

    @property
    def name(self) -> str:
        """Name in files."""
        return f"{self.module}:{self.attribute}" if self.attribute else self.module

    def definitions(self) -> dict[str, Definition]:
        """Return the classes and functions at the top level of the file."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # shown at the import
                tree = ast.parse(read_bytes(self.file, InputError), filename=str(self.file))
            return {definition.name: definition for definition in _defined(tree.body)}
        except InputError as why:
            raise self._fault(f"can't be read: {why}") from why
        except (SyntaxError, ValueError, RecursionError, MemoryError) as why:
            place = line_in(why, {str(self.file)})
            raise self._fault(f"can't be read{place}: {in_words(why)}") from why

    def load(self) -> Any:
        """Import the module, and return it or its object `attribute`.

        It is imported once per run. Outside a run, each call imports it again.
        """
        try:
            with importing() as imports:
                module = imports.module(self.folder, self.module)
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
        definition = getattr(module, self.attribute, None)
        if getattr(definition, "__module__", None) != self.module:
            raise self._fault(
                f"is {definition!r} once {self.file.name} is imported, which is not defined there"
            )
        if not self.kind.accepts(definition):
            raise self._fault(f"({self.file.name}, line {self.line}) is no {self.kind.words}")
        return definition

    def _fault(self, message: str) -> UserError:
        return _fault(self.kind, self.name, message)


@dataclass(frozen=True)
class CodeFolder:
    """Folder of custom code, which is rejected unless it is `allowed`."""

    path: Path = Path()
    allowed: bool = True

    def find(self, name: str, kind: Kind) -> CustomCode:
        """Return the definition of `package.module:name` directly in the folder.

        Nothing is imported. Raise the error of the `kind` if there is no such file, if it cannot be
        parsed, if it does not define that name at its top level, or if custom code is not allowed.
        """
        module, colon, attribute = name.partition(":")
        if not colon and kind.builtin:
            raise kind.error(
                f"no {kind.noun} is called {name!r}; {suggestion(name, kind.builtin)};"
                " your own is package.module:name"
            )
        if not (colon and _is_name(attribute)):
            raise _fault(kind, name, "is not of the form package.module:name")
        code = self._located(name, module, attribute, kind)
        definitions = code.definitions()
        if attribute not in definitions:
            hint = f"; {suggestion(attribute, definitions)}" if definitions else ""
            raise _fault(
                kind,
                name,
                f"can't be found: {code.file.name} defines no class or function {attribute!r} at"
                f" its top level{hint}",
            )
        return replace(code, line=definitions[attribute].lineno)

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


def argument_fault(definition: Any, terms: Mapping[str, Any], *arguments: Any) -> str:
    """Return why a class or function cannot be called with these arguments, or an empty text."""
    try:
        signature = inspect.signature(definition)
    except (TypeError, ValueError):  # written in C
        return ""
    try:
        signature.bind(*arguments, **terms)
    except TypeError as why:
        return f"{why}; it takes {signature}"
    return ""


def _is_name(text: str) -> bool:
    return text.isidentifier() and not keyword.iskeyword(text)


def _defined(body: list[ast.stmt]) -> Iterator[Definition]:
    """Yield the classes and functions of a module, including those under `if` and `try`."""
    for node in body:
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield node
            continue
        for block in ("body", "orelse", "finalbody"):
            yield from _defined(getattr(node, block, []))
        for handler in getattr(node, "handlers", []):
            yield from _defined(handler.body)


FLOORWALKER = ("floorplan", "navigation", "bdi", "sim")
"""Packages of Floorwalker."""

_IMPORTS: ContextVar[Imports | None] = ContextVar("imports", default=None)
"""Modules of the current run."""

_left: dict[str, ModuleType] = {}
"""Modules of the last run that are still loaded."""

_files: set[str | None] = set()
"""Files of all custom code that was imported."""


class Imports:
    """Modules that a run imports from the folders of its custom code.

    Each run imports them again, because modules may have state. While the run is `active` they are
    in `sys.modules` under their plain names, and afterwards until the next run. Modules of the same
    names that the calling program imported are set aside meanwhile.
    """

    def __init__(self) -> None:
        self._modules: dict[Path, dict[str, ModuleType]] = {}
        self._before: dict[Path, set[str]] = {}
        """Names of the modules that were loaded before the code of a folder."""
        self._context = ExitStack()

    @contextmanager
    def active(self) -> Iterator[None]:
        """Import custom code for this run in this context."""
        if _IMPORTS.get() is self:
            yield
            return
        token = _IMPORTS.set(self)
        for name, module in _left.items():
            if sys.modules.get(name) is module:
                del sys.modules[name]
        _left.clear()
        try:
            with ExitStack() as self._context:
                for folder in self._modules:
                    self._context.enter_context(self._looking_in(folder, ()))
                yield
        finally:
            _IMPORTS.reset(token)

    def module(self, folder: Path, name: str) -> ModuleType:
        """Return a module directly in `folder`, or in a package there."""
        if is_known := folder in self._modules:
            self._take(folder)
        own = self._modules.setdefault(folder, {})
        others = {*_others_in(folder, name.partition(".")[0])} - own.keys()
        if others or not is_known:
            self._context.enter_context(self._looking_in(folder, others))
        importlib.invalidate_caches()
        try:
            return importlib.import_module(name)
        finally:
            self._take(folder)

    @contextmanager
    def _looking_in(self, folder: Path, others: Collection[str]) -> Iterator[None]:
        """Import from `folder` first in this context, and set `others` aside meanwhile."""
        own = self._modules[folder]
        aside = {name: sys.modules.pop(name) for name in {*own, *others} if name in sys.modules}
        sys.modules.update(own)
        self._before[folder] = {*sys.modules}
        # Compiled code in __pycache__ is valid for any source of the same second and size.
        compiled, sys.dont_write_bytecode = sys.dont_write_bytecode, True
        sys.path.insert(0, str(folder))
        try:
            yield
        finally:
            sys.path.remove(str(folder))
            sys.dont_write_bytecode = compiled
            self._take(folder)
            taken = {name.partition(".")[0] for name in aside}
            for name, module in own.items():
                if name.partition(".")[0] in taken:
                    sys.modules.pop(name, None)
                else:
                    _left[name] = module
            sys.modules.update(aside)

    def _take(self, folder: Path) -> None:
        """Add the newly imported modules of `folder` to the modules of this run."""
        for name in {*sys.modules} - self._before[folder]:
            if _stands_in(folder, name.partition(".")[0]):
                self._modules[folder][name] = sys.modules[name]
                _files.add(sys.modules[name].__file__)


@contextmanager
def importing() -> Iterator[Imports]:
    """Import custom code for the current run in this context, or for this context alone."""
    imports = _IMPORTS.get()
    if imports is not None:
        yield imports
        return
    imports = Imports()
    with imports.active():
        yield imports


def _others_in(folder: Path, top: str) -> Iterator[str]:
    """Yield the loaded modules in `folder`, and modules called `top` from elsewhere."""
    there = {path.stem for path in folder.iterdir()} - {*FLOORWALKER}
    standing = {name for name in there & sys.modules.keys() if _stands_in(folder, name)}
    for name in [*sys.modules]:
        if name.partition(".")[0] in standing | ({top} - {*FLOORWALKER}):
            yield name


def _stands_in(folder: Path, top: str) -> bool:
    """Return True if the loaded package or module `top` is directly in `folder`."""
    module = sys.modules.get(top)
    places = (*getattr(module, "__path__", ()), getattr(module, "__file__", None))
    return any(place and Path(place).parent.resolve() == folder for place in places)


def code_of(code: Any) -> Any:
    """Return the function or class behind a partial or decorated function or an object."""
    while isinstance(code, partial):
        code = code.func
    return inspect.unwrap(code) if inspect.isroutine(code) or inspect.isclass(code) else type(code)


def file_of(code: Any) -> Path | None:
    """Return the file that defines a function, a class or an object, or None if unknown."""
    try:
        file = inspect.getsourcefile(code_of(code))
    except TypeError:  # built in
        return None
    return None if file is None else Path(file)


def in_words(why: BaseException) -> str:
    """Return the text of an error with its type, because a `KeyError` only has the key."""
    return f"{type(why).__name__}: {why}".removesuffix(": ")


def is_ours(made: object) -> bool:
    """Return True if the class of an object belongs to Floorwalker."""
    return type(made).__module__.partition(".")[0] in FLOORWALKER


def line_in(why: BaseException, files: Container[str | None]) -> str:
    """Return the innermost line in `files` of an error as " (FILE, line N)", or an empty text."""
    frames = traceback.extract_tb(why.__traceback__)
    places = [(frame.filename, frame.lineno) for frame in frames]
    if isinstance(why, SyntaxError) and why.filename is not None:
        places.append((why.filename, why.lineno))
    inside = [(file, line) for file, line in places if file in files]
    return f" ({Path(inside[-1][0]).name}, line {inside[-1][1]})" if inside else ""


def own_line(why: BaseException, *others: str | None) -> str:
    """Return the innermost line in custom code or other files of an error. See `line_in`."""
    return line_in(why, _files.union(others))


@contextmanager
def supervised(clock: Clock | None = None) -> Iterator[None]:
    """Raise an `OwnCodeError` with line and time for errors in custom code.

    Floorwalker's own errors pass, because their messages suffice, except a `PlanningError`, which
    does not name the caller.
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
    """Raise an `OwnCodeError` with the line at which Ctrl-C interrupts custom code."""
    try:
        yield
    except KeyboardInterrupt as why:
        place = own_line(why)
        if not place:
            raise
        raise OwnCodeError(f"your code was interrupted{place}") from why


def is_under_way(frame: FrameType | None) -> bool:
    """Return True if custom code is executing in `frame` or below it."""
    while frame is not None:
        if frame.f_code.co_filename in _files:
            return True
        frame = frame.f_back
    return False
