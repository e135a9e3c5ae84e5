"""Python of the user's own, named in a trial as `package.module:name`."""

from __future__ import annotations

import importlib
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

_imported: dict[Path, dict[str, ModuleType]] = {}
"""What was imported from the folders of trials, by its name there."""


class OwnCodeError(ValueError):
    """Something of the user's own that can't be found."""


def find_own(name: str, folder: Path) -> Any:
    """What `package.module:name` names.

    Modules are looked up in `folder`, where the trial stands, and as `import` does. A module or a
    package beside the trial is that one, whatever else of its name was imported before.
    `OwnCodeError` says what is missing.
    """
    module_name, colon, attribute = name.partition(":")
    if not (colon and module_name and attribute):
        raise OwnCodeError(f"{name!r} is not of the form package.module:name")
    file = None
    try:
        file = _file_of(module_name, folder)
        with _looked_up_in(folder.resolve(), _top(module_name) if file else ""):
            module = importlib.import_module(module_name)
    except Exception as why:
        place = line_in(why, file)
        raise OwnCodeError(f"{name!r} can't be imported{place}: {in_words(why)}") from why
    found = getattr(module, attribute, None)
    if found is None:
        raise OwnCodeError(f"{module_name} has no {attribute!r}")
    return found


def source_of(name: str, folder: Path) -> str | None:
    """The file in which `name`, found before by `find_own`, is written; None if unknown."""
    module_name = name.partition(":")[0]
    file = _file_of(module_name, folder)
    return file or getattr(sys.modules.get(module_name), "__file__", None)


def in_words(why: BaseException) -> str:
    """What went wrong, with its type: a `KeyError` says no more than the key."""
    return f"{type(why).__name__}: {why}".removesuffix(": ")


def line_in(why: BaseException, file: str | None) -> str:
    """Where in the source `file` an error arose, as " (FILE, line N)"; nothing if elsewhere."""
    frames = traceback.extract_tb(why.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == file]
    if isinstance(why, SyntaxError) and why.filename == file:
        lines.append(why.lineno)
    return f" ({Path(file).name}, line {lines[-1]})" if file and lines else ""


def _file_of(module_name: str, folder: Path) -> str | None:
    """The file of a module or package beside the trial, if it is one."""
    path = folder.resolve().joinpath(*module_name.split("."))
    files = (path / "__init__.py", path.parent / f"{path.name}.py")
    return next((str(file) for file in files if file.is_file()), None)


def _top(module_name: str) -> str:
    return module_name.partition(".")[0]


@contextmanager
def _looked_up_in(folder: Path, top: str) -> Iterator[None]:
    """Let `import` look into `folder` first, and know nothing from the folders of other trials.

    What is called `top` and stands elsewhere is set aside meanwhile.
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
    """What is loaded of the package, or the module, called `top`."""
    return [name for name in sys.modules if _top(name) == top]


def _stands_in(folder: Path, top: str) -> bool:
    """Whether the package or module that is loaded as `top` stands right in `folder`."""
    module = sys.modules.get(top)
    places = (*getattr(module, "__path__", ()), getattr(module, "__file__", None))
    return any(place and Path(place).parent.resolve() == folder for place in places)
