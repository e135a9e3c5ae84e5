"""The command in a separate process, for tests."""

import os
import subprocess
import sys

from waiting import HANG


def command_line(*words, options=()):
    """Return the command line, started with these options of Python."""
    return [sys.executable, *options, "-m", "floorwalker", *map(str, words)]


def in_a_process(*words, cwd, env=None, options=()):
    """Run the command to its end, and return it with its output."""
    return subprocess.run(
        command_line(*words, options=options),
        cwd=cwd,
        env={**os.environ, **(env or {})},
        capture_output=True,
        text=True,
        timeout=HANG,
    )


def started(*words, cwd, **options):
    """Start the command."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen(command_line(*words), cwd=cwd, **pipes, **options)
