"""The command in a process of its own, for tests."""

import os
import subprocess
import sys

from waiting import HANG


def command_line(*words, options=()):
    """The words of the command, started with these options of Python."""
    return [sys.executable, *options, "-m", "floorwalker", *map(str, words)]


def in_a_process(*words, cwd, env=None, options=()):
    """The command at its end, with what it has printed."""
    return subprocess.run(
        command_line(*words, options=options),
        cwd=cwd,
        env={**os.environ, **(env or {})},
        capture_output=True,
        text=True,
        timeout=HANG,
    )


def started(*words, cwd, **options):
    """The command as it has begun."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen(command_line(*words), cwd=cwd, **pipes, **options)
