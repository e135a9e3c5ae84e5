"""Entry points of Floorwalker: its command, and its plugin of pytest.

Its packages have short names. Where a file of the user's own hides one of them (a `sim.py` in the
folder where Python starts), the command says so, and pytest goes on without the plugin.
"""

import gc
import sys
from importlib.util import find_spec

PACKAGES = ("floorplan", "navigation", "bdi", "sim")

GARBAGE = 200_000
"""Number of new objects at which those among them that nobody has any more are looked for."""


def _hidden() -> str:
    """Return the message about a file that hides a package; empty if there is none."""
    for package in PACKAGES:
        spec = find_spec(package)
        if spec is not None and not spec.submodule_search_locations:
            return (
                f"{spec.origin} hides Floorwalker's package {package}:"
                " rename the file, or start Python elsewhere"
            )
    return ""


def main() -> None:
    """Run the command `floorwalker`."""
    if hidden := _hidden():
        sys.exit(f"floorwalker: {hidden}")
    # Loading makes fewer objects than that, which stay: no use looking through them for garbage.
    gc.set_threshold(GARBAGE)
    from sim.cli import main as command

    command()


if message := _hidden():

    def pytest_report_header() -> str:
        """Say in pytest's header that the plugin is off, and why."""
        return f"floorwalker: off, since {message}"
else:
    pytest_plugins = ("sim.pytest_plugin",)

if __name__ == "__main__":
    main()
