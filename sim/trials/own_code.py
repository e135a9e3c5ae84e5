"""Python of the user's own, named in a trial as `package.module:name`."""

from __future__ import annotations

import importlib
import importlib.util
import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any


class OwnCodeError(ValueError):
    """Something of the user's own that can't be found."""


def find_own(name: str, folder: Path) -> Any:
    """What `package.module:name` names.

    Modules are looked up in `folder`, where the trial stands, and as `import` does. A module
    beside the trial is that one, whatever else of its name was imported before.
    `OwnCodeError` says what is missing.
    """
    module_name, colon, attribute = name.partition(":")
    if not (colon and module_name and attribute):
        raise OwnCodeError(f"{name!r} is not of the form package.module:name")
    file = _file_of(module_name, folder)
    try:
        with _looked_up_in(file.parent):
            module = _module_in(file) if file.is_file() else importlib.import_module(module_name)
    except Exception as why:
        place, reason = line_in(why, str(file)), why or type(why).__name__
        raise OwnCodeError(f"{name!r} can't be imported{place}: {reason}") from why
    found = getattr(module, attribute, None)
    if found is None:
        raise OwnCodeError(f"{module_name} has no {attribute!r}")
    return found


def source_of(name: str, folder: Path) -> str | None:
    """The file in which `name`, found before by `find_own`, is written; None if unknown."""
    module_name = name.partition(":")[0]
    file = _file_of(module_name, folder)
    return str(file) if file.is_file() else getattr(sys.modules.get(module_name), "__file__", None)


def line_in(why: BaseException, file: str | None) -> str:
    """Where in the source `file` an error arose, as " (FILE, line N)"; nothing if elsewhere."""
    frames = traceback.extract_tb(why.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == file]
    if isinstance(why, SyntaxError) and why.filename == file:
        lines.append(why.lineno)
    return f" ({Path(file).name}, line {lines[-1]})" if file and lines else ""


def _file_of(module_name: str, folder: Path) -> Path:
    return folder.resolve() / f"{module_name}.py"


@contextmanager
def _looked_up_in(folder: Path) -> Iterator[None]:
    sys.path.insert(0, str(folder))
    try:
        yield
    finally:
        sys.path.remove(str(folder))


def _module_in(file: Path) -> ModuleType:
    name = file.stem
    before = sys.modules.get(name)
    if before is not None and getattr(before, "__file__", None) == str(file):
        return before
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise ImportError(f"{file.name} is not a Python module")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    finally:
        if before is not None:
            sys.modules[name] = before
    return module
