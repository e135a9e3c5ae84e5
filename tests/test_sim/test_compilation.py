"""Uncompiled kernels are reported once, and only if trials are run."""

import subprocess
import sys

import pytest

from sim.core.compilation import NOTICE

UNCOMPILED = """
import navigation.kernels
navigation.kernels.COMPILED = False
import sys, sim
trial = sim.Trial.parse("{floorplan: ariac2023, duration: 1.0, people: [{name: eve}]}")
"""
ACTIONS = {
    "sim.run": "sim.run(trial); sim.run(trial)",
    "a study": "list(sim.run_many([trial] * 2, jobs=2))",
    "a benchmark": "sys.argv[1:] = 'benchmark --planner RRTConnect --queries 1 --out b'.split()\n"
    "from sim.cli import main\nmain()",
}


def stderr_of(code, folder):
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stderr


@pytest.mark.parametrize(
    "action", ["sim.run", *(pytest.param(one, marks=pytest.mark.slow) for one in (*ACTIONS,)[1:])]
)
def test_uncompiled_kernels_are_reported_once_with_the_remedy(action, tmp_path):
    stderr = stderr_of(f"{UNCOMPILED}{ACTIONS[action]}", tmp_path)
    assert stderr.count(NOTICE) == 1 and "pip install" in NOTICE


def test_a_trial_that_is_only_loaded_has_no_notice(tmp_path):
    assert stderr_of(UNCOMPILED, tmp_path) == ""
