"""Results do not depend on the caches that a process has for a floor."""

import hashlib
import json
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import navigation
import sim

ROOT = Path(__file__).resolve().parents[2]
CODE = "import sys, sim; sys.path.insert(0, 'tests/test_sim'); import test_ground as t; t.tell()"


def digest(trial):
    """Return a digest of a run without its costs."""
    run = sim.run(trial)
    cost = ("cpu_seconds", "realtime_factor")
    summary = {key: value for key, value in run.summary.items() if key not in cost}
    pieces = {name: list(motion.pieces) for name, motion in run.motions.items()}
    return hashlib.sha256(json.dumps([summary, run.events, pieces]).encode()).hexdigest()


def trials():
    """Return trials on the same floor, with another size of person, and on another floor."""
    curious = sim.Trial.load(ROOT / "examples" / "two_people.trial.yaml")
    wide = replace(curious, people=tuple(replace(p, radius=0.4) for p in curious.people))
    return [
        sim.Trial.load("ariac2023"),
        sim.Trial.load(ROOT / "examples" / "warehouse.trial.yaml"),
        wide,
        curious,
    ]


def tell():
    print(digest(trials()[-1]))


def test_a_run_after_others_equals_one_in_a_fresh_process():
    *others, last = trials()
    for trial in others:
        sim.run(trial)
    command = [sys.executable, "-c", CODE]
    fresh = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert [digest(last), digest(last)] == fresh.stdout.split() * 2


def test_worlds_on_one_floor_share_roadmaps_and_spaces():
    plan = sim.Trial.load("ariac2023").floorplan
    one, other = (navigation.PathPlanner(navigation.CollisionWorld(plan), 0.3) for _ in range(2))
    assert one.roadmap() is other.roadmap()
    assert one.roadmap() is not navigation.PathPlanner(one.world, 0.31).roadmap()
    assert one.world.fixed_space(0.3) is other.world.fixed_space(0.3)


def test_only_recent_spaces_stay_cached():
    plan = sim.Trial.load("ariac2023").floorplan
    world = navigation.CollisionWorld(plan)
    spaces = [world.fixed_space(0.3 + k / 100) for k in range(40)]
    fresh = navigation.CollisionWorld(plan)
    assert fresh.fixed_space(0.3 + 39 / 100) is spaces[-1]
    assert fresh.fixed_space(0.3) is not spaces[0]


def test_threads_share_nothing():
    world = navigation.CollisionWorld(sim.Trial.load("ariac2023").floorplan)
    spaces = []

    def look():
        fresh = navigation.CollisionWorld(world.plan)
        spaces.append(fresh.fixed_space(0.3))

    thread = threading.Thread(target=look)
    thread.start()
    thread.join()
    assert spaces[0] is not world.fixed_space(0.3)
