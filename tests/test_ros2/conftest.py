"""Processes with a real rclpy, which only find each other on this machine."""

import json
import os
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest
from cells import HANG

HERE = Path(__file__).parent
FOLDER = Path(os.environ.get("FLOORWALKER_ROS", Path.home() / ".cache" / "floorwalker-ros"))
PYTHON = FOLDER / "venv" / "bin" / "python"
READY = FOLDER / f"wheels-{sys.implementation.cache_tag}"


class Ros:
    """Processes of one domain: the command `floorwalker ros2`, and clients of `client.py`."""

    def __init__(self, domain, folder):
        self.folder = folder
        libraries = [one for one in sys.path if one.endswith(("site-packages", "dist-packages"))]
        self.environment = {
            **os.environ,
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_DOMAIN_ID": str(domain),
            "ROS_LOG_DIR": str(folder / "log"),
            "AMENT_PREFIX_PATH": str(FOLDER / "venv"),
            "LD_LIBRARY_PATH": str(FOLDER / "venv" / "lib"),
            # The packages that are tested come before those of ROS, which have another lark.
            "PYTHONPATH": os.pathsep.join([os.environ["PYTHONPATH"], *libraries]),
        }

    def start(self, *words):
        """Start Python with these arguments."""
        return subprocess.Popen(
            [str(PYTHON), *map(str, words)],
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    @contextmanager
    def serving(self, trial, *options):
        """Serve a trial; the process has its whole output in `notices` and `code` at the end."""
        (self.folder / "cell.trial.yaml").write_text(trial)
        server = self.start("-m", "floorwalker", "ros2", "cell.trial.yaml", *options)
        server.notices = ""
        try:
            for line in server.stderr:
                server.notices += line
                if line.startswith("serving"):
                    break
            yield server
            if server.poll() is None:
                server.send_signal(2)
        finally:
            out, err = server.communicate(timeout=HANG)
            server.notices += err
            server.output = out

    def client(self, function, **arguments):
        """Return what a function of `client.py` returns in a process of its own."""
        client = self.start(HERE / "client.py", function, json.dumps(arguments))
        out, err = client.communicate(timeout=HANG)
        assert client.returncode == 0, err
        return json.loads(out.splitlines()[-1])


@pytest.fixture
def ros(tmp_path, request):
    """Processes of a domain of this process of pytest; skips without rclpy or messages."""
    if not READY.exists():
        pytest.skip(f"{READY} does not exist: run tests/test_ros2/environment.sh {FOLDER}")
    for marker in request.node.iter_markers("messages"):
        for package in marker.args:
            if not (FOLDER / "build" / package / "done").exists():
                pytest.skip(f"{FOLDER} has no {package}: see tests/test_ros2/environment.sh")
    return Ros(1 + os.getpid() % 100, tmp_path)
