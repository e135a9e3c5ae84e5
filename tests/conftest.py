"""Fixtures and settings of all tests: the command in this process, kinds of events, Hypothesis."""

import gc
import os
import shutil
import signal
import subprocess
import sys
from contextlib import ExitStack, suppress
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from floorplan.files.collector import frozen_collector
from floorwalker import main
from sim.core.compilation import notice_uncompiled
from sim.core.events import EVENT_KINDS
from sim.views.film import installed_chromium

ALWAYS = {
    "deadline": None,
    "print_blob": True,
    "suppress_health_check": [HealthCheck.too_slow],
}
settings.register_profile("explore", max_examples=1000, derandomize=False, **ALWAYS)
settings.register_profile("default", max_examples=30, derandomize=True, **ALWAYS)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))

# Hypothesis also tries constants of the modules that are loaded when a test begins. They depend on
# the tests that ran before in the same worker, and no setting prevents it.
with suppress(ImportError):
    from hypothesis.internal.conjecture import providers

    providers._get_local_constants = lambda: providers._local_constants

# Processes that tests start import the packages under test, installed or not, from any folder.
TESTED = str(Path(str(find_spec("navigation").origin)).parents[1])
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [TESTED, os.environ.get("PYTHONPATH")]))

if sys.dont_write_bytecode:
    # Otherwise each worker and each process that a test starts compiles all sources again.
    BYTECODE = Path(__file__).resolve().parents[1] / ".pytest_cache" / "bytecode"
    sys.dont_write_bytecode, sys.pycache_prefix = False, str(BYTECODE)
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ["PYTHONPYCACHEPREFIX"] = str(BYTECODE)

MEMORY = Path("/dev/shm")
ROOM = 4e9
"""Bytes. More than the files of the tests need."""

if os.access(MEMORY, os.W_OK) and shutil.disk_usage(MEMORY).free > ROOM:
    # Tests write thousands of small files, for which disks are slow.
    os.environ.setdefault("PYTEST_DEBUG_TEMPROOT", str(MEMORY))

notice_uncompiled()  # here, and not in the first test that runs a trial

FROZEN = ExitStack()
"""The state of the collector during all tests."""

pytest_plugins = ["pytester"]
if "floorwalker" not in entry_points(group="pytest11").names:
    # The sources are used without a new installation, so that pytest does not know the plugin yet.
    pytest_plugins.append("sim.pytest_plugin")

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # Shells start background jobs with Ctrl-C ignored, and commands would inherit that.
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_finish():
    """Exclude thousands of tests and libraries, which stay to the end, from garbage collection."""
    gc.collect()
    FROZEN.enter_context(frozen_collector())


def pytest_sessionfinish():
    """Return the objects to the collector, because nanobind reports remaining objects as leaks."""
    FROZEN.close()


@pytest.fixture(autouse=True)
def event_kinds():
    """Yield all kinds of events by name. Kinds added by a test are removed after it."""
    before = dict(EVENT_KINDS)
    yield EVENT_KINDS
    EVENT_KINDS.clear()
    EVENT_KINDS.update(before)


@pytest.fixture(scope="session")
def chromium():
    """Return the path of Chromium or Chrome, or skip the test."""
    path = installed_chromium()
    if path is None:
        pytest.skip("no Chromium on this machine")
    return path


@pytest.fixture
def floorwalker(capfd, monkeypatch):
    """Run the command in this process, in the folder `cwd`, because a new process starts slowly."""

    def called(*words, cwd="."):
        capfd.readouterr()
        with monkeypatch.context() as now:
            now.chdir(cwd)
            now.setattr(sys, "argv", ["floorwalker", *map(str, words)])
            with pytest.raises(SystemExit) as ended:
                main()
        return subprocess.CompletedProcess(words, ended.value.code or 0, *capfd.readouterr())

    return called
