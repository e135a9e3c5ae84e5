"""Files of custom code: a module, and the modules beside it that it imports.

They are located by the import statements, because nothing is imported before a study runs. A module
that imports others by computed names may import all that is in its folder.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from importlib.machinery import all_suffixes
from pathlib import Path
from typing import Any

from ..core.custom_code import FLOORWALKER, CustomCode, code_of, file_of
from ..machines.policy_files import PolicyFile

INSTALLED = {"site-packages", "dist-packages"}
"""Folders of installed packages."""

IMPORTERS = {"import_module", "__import__", "run_module", "run_path", "exec", "find_spec"}
IMPORTERS |= {"spec_from_file_location"}
"""Functions that import what their first argument states."""


def digest_of_source(source: CustomCode | PolicyFile) -> str:
    """Return the digest of all files that custom code imports from its folder."""
    return _digest(source.file, source.folder, "")


def digest_of_code(code: Any) -> str:
    """Return the digest of a function, class or object. Of an installed one, the package counts."""
    file = file_of(code)
    if file is None:
        return "unknown"
    module = str(code_of(code).__module__).split(".")
    if module[0] in FLOORWALKER:
        return hashlib.sha256(file.read_bytes()).hexdigest()[:16]
    depth = len(module) if file.name == "__init__.py" else len(module) - 1
    package = "" if INSTALLED.isdisjoint(file.parts) else module[0]
    return _digest(file, file.parents[depth], package)


def _digest(file: Path, folder: Path, package: str) -> str:
    """Return the digest of `file` and its imports from `folder`, or from a package there."""
    contents: dict[str, bytes] = {}
    waiting = [file]
    while waiting:
        path = waiting.pop()
        name = path.relative_to(folder).as_posix()
        if name not in contents:
            contents[name] = path.read_bytes()
            waiting += _imported(path, contents[name], folder, package)
    digest = hashlib.sha256()
    for name in sorted(contents):
        digest.update(f"{name} {len(contents[name])} ".encode() + contents[name])
    return digest.hexdigest()[:16]


def _imported(path: Path, content: bytes, folder: Path, package: str) -> Iterator[Path]:
    """Yield the files in `folder` that a file imports anywhere in its text."""
    try:
        tree = ast.parse(content) if path.suffix == ".py" else None
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return
    here = path.relative_to(folder).parts[:-1]
    for node in () if tree is None else ast.walk(tree):
        for module in _modules(node, here):
            if module is None:
                for pattern in ("*.py", "[!.]*/**/*.py"):
                    modules = folder.glob(f"{package}/{pattern}" if package else pattern)
                    yield from (one for one in modules if INSTALLED.isdisjoint(one.parts))
            elif not package or module[0] == package:
                yield from _files(module, folder)


def _modules(node: ast.AST, here: tuple[str, ...]) -> Iterator[list[str] | None]:
    """Yield the parts of the modules that a node imports in the package `here`, or None if any."""
    match node:
        case ast.Import(names=names):
            yield from (alias.name.split(".") for alias in names)
        case ast.ImportFrom(module=module, names=names, level=level):
            base = [*here[: len(here) - level + 1]] if level else []
            base += module.split(".") if module else []
            yield from ([*base, alias.name] for alias in names)
        case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name), args=arguments):
            if name in IMPORTERS:
                match arguments:
                    case [ast.Constant(value=str(text)), *_] if name != "exec":
                        dots = len(text) - len(text.lstrip("."))
                        base = [*here[: len(here) - dots + 1]] if dots else []
                        yield [*base, *text.lstrip(".").split(".")]
                    case _:
                        yield None


def _files(module: list[str], folder: Path) -> Iterator[Path]:
    """Yield the file of a module in `folder`, and the files of the packages around it."""
    for part in module:
        for suffix in all_suffixes():
            for file in (folder / part / f"__init__{suffix}", folder / f"{part}{suffix}"):
                if file.is_file():
                    yield file
        folder = folder / part
