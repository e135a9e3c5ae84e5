"""What all tests share: the real data beside the repository, and how hypothesis runs."""

import os
import signal
from importlib.metadata import entry_points
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile(
    "default", deadline=None, derandomize=True, print_blob=True, max_examples=50
)
settings.register_profile("ci", settings.get_profile("default"), max_examples=100)
settings.register_profile("thorough", deadline=None, max_examples=3000)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "default"))

pytest_plugins = ["pytester"]
if "floorwalker" not in entry_points(group="pytest11").names:
    # The sources are used without being installed anew: pytest does not know the plugin yet.
    pytest_plugins.append("sim.pytest_plugin")

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # Shells start what runs in the background deaf to Ctrl-C, which commands would inherit.
    signal.signal(signal.SIGINT, signal.default_int_handler)

SHARED = Path(__file__).resolve().parents[2] / "shared" / "data"


@pytest.fixture
def shared_data():
    """The folder with real trial files, maps and agent traces; skips where it is missing."""
    if not SHARED.is_dir():
        pytest.skip("the real data (../shared/data) are not beside this repository")
    return SHARED
