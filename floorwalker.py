"""Entry points of Floorwalker: its command, and its plugin of pytest.

Its packages have short names. If the user's own file or folder hides one of them (a `sim.py` in the
folder where Python starts), the command says so, and pytest goes on without the plugin.
"""

import atexit
import gc
import os
import sys
import threading
from importlib.util import find_spec
from pathlib import Path

PACKAGES = ("floorplan", "navigation", "bdi", "sim")

GARBAGE = 200_000
"""Number of new objects at which Python looks for unused ones among them."""


def _hidden() -> str:
    """Return the message about a file that hides a package; empty if there is none."""
    for package in PACKAGES:
        spec = find_spec(package)
        places = [] if spec is None else [spec.origin, *(spec.submodule_search_locations or ())]
        found = next((Path(place) for place in places if place), None)
        ours = Path(__file__).resolve().parent / package
        if found is not None and ours not in (found.resolve(), found.resolve().parent):
            ours = f"Floorwalker's package {package}"
            return f"{found} hides {ours}: rename it, or start Python elsewhere"
    return ""


def main() -> None:
    """Run the command `floorwalker`."""
    if hidden := _hidden():
        sys.exit(f"floorwalker: {hidden}")
    # Loading makes fewer objects than that, which stay: no use looking through them for garbage.
    gc.set_threshold(GARBAGE)
    from sim.cli import main as command

    try:
        command()
    except SystemExit as end:
        _leave(end.code)
        raise


def _leave(code: object) -> None:
    """End the process as Python does, but without taking apart everything that was loaded.

    That takes 0.11 s of CPU time of 0.64 s of `floorwalker run`. Return where there is more to do
    at the end: in another program, beside threads, with a message for Python to print, and under a
    debugger or profiler.
    """
    program = Path(getattr(sys.modules["__main__"], "__file__", None) or "")
    looked_at = sys.flags.dev_mode or sys.gettrace() or sys.getprofile()
    if program.stem != "floorwalker" or looked_at or threading.active_count() > 1:
        return
    if not isinstance(code, int | None):
        return
    atexit._run_exitfuncs()
    try:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
    except (AttributeError, OSError, ValueError):  # none, or closed: Python has its word on it
        return
    os._exit(code or 0)


if message := _hidden():

    def pytest_report_header() -> str:
        """Say in pytest's header that the plugin is off, and why."""
        return f"floorwalker: off, since {message}"
else:
    pytest_plugins = ("sim.pytest_plugin",)

if __name__ == "__main__":
    main()
