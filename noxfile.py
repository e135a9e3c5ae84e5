"""Checks that need other environments than the one at hand: `nox -l` lists them."""

import random
import shutil
from pathlib import Path

import nox

PYTHONS = ("3.10", "3.11", "3.12", "3.13")
PACKAGES = ("floorplan", "navigation", "bdi", "sim")

nox.needs_version = ">=2024.4.15"
nox.options.sessions = ["tests", "lowest", "coverage"]
nox.options.error_on_missing_interpreters = False


def _built(session: nox.Session) -> tuple[Path, Path]:
    """Build a wheel and return it with the unpacked sdist without its packages."""
    folder = Path(session.create_tmp()).resolve()
    shutil.rmtree(folder)
    session.install("build")
    session.run("python", "-m", "build", "--outdir", str(folder), silent=True)
    (sdist,) = folder.glob("*.tar.gz")
    (wheel,) = folder.glob("*.whl")
    shutil.unpack_archive(sdist, folder)
    unpacked = folder / sdist.name.removesuffix(".tar.gz")
    for package in PACKAGES:
        shutil.rmtree(unpacked / package)
    return wheel, unpacked


@nox.session(python=PYTHONS)
def tests(session: nox.Session) -> None:
    """Run the tests of the sdist against the installed wheel. More arguments go to pytest."""
    wheel, unpacked = _built(session)
    session.install(f"{wheel}[test]")
    with session.chdir(unpacked):
        session.run("python", "-m", "pytest", *session.posargs)


@nox.session(python="3.10", venv_backend="uv")
def lowest(session: nox.Session) -> None:
    """Run the tests with the lowest versions that pyproject.toml allows."""
    wheel, unpacked = _built(session)
    with session.chdir(unpacked):
        session.install("--resolution", "lowest-direct", "-r", "pyproject.toml", "--extra", "test")
        session.install("--no-deps", str(wheel))
        # Warnings of old versions of dependencies are no defects of this project.
        options = ("-W", "default", "--deselect", "tests/test_sim/test_clean_output.py")
        session.run("python", "-m", "pytest", *options, *session.posargs)


@nox.session
def explore(session: nox.Session) -> None:
    """Run property tests with many random cases. More arguments go to pytest.

    Before them, trials that are drawn at random.
    """
    session.install("-e", ".[test]")
    first = str(random.randrange(10**9))
    session.run("python", "-m", "tests.random_trials", "--trials", "300", "--first", first)
    explore = {"HYPOTHESIS_PROFILE": "explore"}
    halls = "tests/random_trials/test_open_halls.py"
    session.run("python", "-m", "pytest", "-m", "slow", halls, env=explore)
    session.run(
        *("python", "-m", "pytest", "-m", "hypothesis and not slow"),
        *("-o", "faulthandler_timeout=300", *session.posargs),
        env=explore,
    )


@nox.session
def published(session: nox.Session) -> None:
    """Compare published tables and pictures that do not depend on the machine.

    The documents then have the new ones. More arguments are names of some of them.
    """
    session.install("-e", ".[test,peers]")
    session.run("python", "docs/published.py", *session.posargs)


@nox.session
def coverage(session: nox.Session) -> None:
    """Which lines and branches the tests take, in this process, workers and commands."""
    session.install("-e", ".[test]")
    session.run("coverage", "erase")
    session.run("coverage", "run", "-m", "pytest", *session.posargs)
    session.run("coverage", "combine", "--quiet")
    for package in PACKAGES:
        session.run("coverage", "report", "--skip-covered", f"--include={package}/*")
    for package in PACKAGES:
        session.run(
            "coverage", "report", "--fail-under=90", "--format=total", f"--include={package}/*"
        )
