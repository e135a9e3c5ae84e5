"""The run of a module, full disks, and a browser for pages, where there is one."""

import sys
import threading
from contextlib import contextmanager
from pathlib import Path

import pytest
from replay_viewer import Viewer
from waiting import HANG

import sim

ENDS_WITHIN = 30.0
"""Time (s) within which a thread ends after its helper has stopped it."""

ARGUMENTS = [
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]


@pytest.fixture(autouse=True, scope="module")
def no_thread_stays():
    """Require that a module leaves no thread behind, because it would disturb other tests."""
    before = {*threading.enumerate()}
    yield
    if workers := sys.modules.get("joblib.externals.loky"):
        workers.get_reusable_executor().shutdown(wait=True)  # joblib reuses them
    for thread in {*threading.enumerate()} - before:
        if thread.name.startswith("Dask-Offload"):  # an idle pool of Dask
            continue
        thread.join(ENDS_WITHIN)
        assert not thread.is_alive(), f"{thread} is still running"


@pytest.fixture(scope="module")
def run(request):
    """The run of a module's `TRIAL`, shared by all of its tests."""
    return sim.run(sim.Trial.parse(request.module.TRIAL))


@pytest.fixture
def room_for(monkeypatch):
    """Return a context that limits the size of files (bytes), as a full disk does."""
    resource = pytest.importorskip("resource")

    @contextmanager
    def room_for(size):
        before = resource.getrlimit(resource.RLIMIT_FSIZE)
        with monkeypatch.context() as now:
            # Python would write truncated bytecode, and fail to import it again.
            now.setattr(sys, "dont_write_bytecode", True)
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
            try:
                yield
            finally:
                resource.setrlimit(resource.RLIMIT_FSIZE, before)

    return room_for


@pytest.fixture(scope="module")
def browser(chromium):
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with api.sync_playwright() as driver:
        browser = driver.chromium.launch(
            executable_path=chromium, args=ARGUMENTS, timeout=1000 * HANG
        )
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def axe():
    """The script of axe-core, which finds barriers for disabled people in a page."""
    package = pytest.importorskip("axe_playwright_python", reason="axe-core is not installed")
    [script] = Path(package.__file__).parent.rglob("axe.min.js")
    return script.read_text(encoding="utf-8")


@pytest.fixture
def open_address(browser):
    """Return a function that opens addresses in the browser until the end of the test."""
    viewers = []

    def open_address(address, **options):
        viewers.append(Viewer(browser, address, **options))
        return viewers[-1]

    yield open_address
    for viewer in viewers:
        viewer.context.close()


@pytest.fixture
def open_page(open_address, tmp_path):
    """Return a function that opens HTML text as a page, from disk."""
    numbers = iter(range(1000))

    def open_page(html, **options):
        file = tmp_path / f"{next(numbers)}.html"
        file.write_text(html, encoding="utf-8")
        return open_address(file.as_uri(), **options)

    return open_page


@pytest.fixture(scope="module")
def open_shared_page(browser, tmp_path_factory):
    """Return the same function for a page that all tests of a module share."""
    viewers = []

    def open_page(html, **options):
        file = tmp_path_factory.mktemp("page") / "page.html"
        file.write_text(html, encoding="utf-8")
        viewers.append(Viewer(browser, file.as_uri(), **options))
        return viewers[-1]

    yield open_page
    for viewer in viewers:
        viewer.context.close()
