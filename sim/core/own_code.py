"""Python of the user's own, imported from the folder in which it stands."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.machinery import BuiltinImporter, FrozenImporter
from pathlib import Path
from types import FrameType, ModuleType
from typing import Any

from navigation import PlanningError

from .clock import Clock
from .own_source import OwnCodeError, Source, in_words, is_ours, line_in, misfit

_imported: dict[Path, dict[str, ModuleType]] = {}
"""Modules imported from the folders of trials, by their names there."""


def import_own(source: Source) -> Any:
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


def _refuse_names_of_python(source: Source) -> None:
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
