"""Distributions: a wheel and an sdist, built from the sources as they are."""

import os
import shutil
import subprocess
import sys
import tarfile
import venv
import zipfile
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("floorplan", "navigation", "bdi", "sim")
FOLDERS = (*PACKAGES, "tests", "docs", "examples", "benchmarks")
ENTRY = "floorwalker.py"
FILES = (
    "README.md",
    "LICENSE",
    "CHANGELOG.md",
    "CITATION.cff",
    "CONTRIBUTING.md",
    "MANIFEST.in",
    "mkdocs.yml",
    "noxfile.py",
    "setup.py",
)
REBUILT = {".git", ".venv", ".mypy_cache", ".pytest_cache", "build", "dist", "site", "runs"}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not (ROOT / "sim").is_dir(), reason="the sources are not there"),
]


@pytest.fixture(scope="module")
def built(tmp_path_factory, testrun_uid):
    """Return the folder with a wheel and an sdist, built once for all processes of the tests."""
    pytest.importorskip("build", reason="the package build is not installed")
    filelock = pytest.importorskip("filelock", reason="the package filelock is not installed")
    folder = tmp_path_factory.getbasetemp().parent / f"distribution-{testrun_uid}"
    with filelock.FileLock(folder.with_suffix(".lock")):
        if not folder.exists():
            build(folder)
    return folder


def build(folder):
    """Build an sdist of the sources, and a wheel from it."""
    source = folder / "source"
    at_top = {str(ROOT): REBUILT}
    shutil.copytree(ROOT, source, ignore=lambda path, names: at_top.get(path, set()) & set(names))
    command = [sys.executable, "-m", "build", "--outdir", str(folder), str(source)]
    quickly = {**os.environ, "CFLAGS": "-O0"}
    done = subprocess.run(command, capture_output=True, text=True, env=quickly)
    assert done.returncode == 0, done.stdout + done.stderr


BY_PRODUCTS = {"__pycache__", ".hypothesis"}


def ours(folder):
    """Return files in a folder of the sources that are no by-products, with paths from above."""
    for path in folder.rglob("*"):
        compiled = path.name.endswith(tuple(EXTENSION_SUFFIXES))
        if path.is_file() and not (compiled or BY_PRODUCTS & {*path.parts}):
            yield path.relative_to(folder.parent).as_posix()


def test_the_sdist_has_all_files_for_tests_and_documents(built):
    (file,) = built.glob("floorwalker-*.tar.gz")
    with tarfile.open(file) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    expected = {path for folder in FOLDERS for path in ours(ROOT / folder)}
    assert expected | {*FILES, ENTRY, "pyproject.toml"} <= names
    assert not [name for name in names if "__pycache__" in name]


def test_the_wheel_has_the_packages_and_nothing_else(built):
    (file,) = built.glob("floorwalker-*.whl")
    with zipfile.ZipFile(file) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
        names = {name for name in names if not name.endswith(tuple(EXTENSION_SUFFIXES))}
        licence = [name for name in archive.namelist() if name.endswith("LICENSE")]
    assert names == {ENTRY} | {path for package in PACKAGES for path in ours(ROOT / package)}
    assert licence


def test_the_readme_can_be_shown(built):
    pytest.importorskip("twine", reason="twine is not installed")
    files = [str(file) for file in built.glob("floorwalker-*.*")]
    done = subprocess.run(
        [sys.executable, "-m", "twine", "check", "--strict", *files], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture
def clean():
    """Environment variables with which the tested packages cannot be imported."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


def test_a_wheel_installs_and_runs_in_an_empty_environment(built, clean, tmp_path):
    (wheel,) = built.glob("floorwalker-*.whl")
    environment = tmp_path / "environment"
    venv.create(environment, with_pip=True)
    python = environment / ("Scripts" if os.name == "nt" else "bin") / "python"
    pip = [str(python), "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "install", "--no-compile", str(wheel)], check=True, env=clean)
    command = str(python.parent / "floorwalker")
    for arguments in (["run", "--out", str(tmp_path / "out")], ["list"], ["--version"]):
        done = subprocess.run(
            [command, *arguments], cwd=tmp_path, env=clean, capture_output=True, text=True
        )
        assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "out" / "replay.html").stat().st_size > 50_000


def test_the_sdist_installs_without_a_compiler(built, clean, tmp_path):
    (sdist,) = built.glob("floorwalker-*.tar.gz")
    environment = tmp_path / "environment"
    venv.create(environment, with_pip=True)
    python = environment / ("Scripts" if os.name == "nt" else "bin") / "python"
    pip = [str(python), "-m", "pip", "--quiet", "--disable-pip-version-check"]
    nothing = {**clean, "CC": str(tmp_path / "nothing")}
    subprocess.run([*pip, "install", "--no-deps", str(sdist)], check=True, env=nothing)
    kernels = [path for path in environment.rglob("kernels/[a-z]*") if path.is_file()]
    assert {path.suffix for path in kernels} == {".py", ".pxd"}
