"""Kernels give the same, to the last bit, whether they are compiled or not."""

import subprocess
import sys

import numpy as np
import pytest

from navigation import polynomials as quadrature
from navigation.kernels import COMPILED

AS_PYTHON = """
import importlib.machinery, importlib.util, pathlib, sys

class Sources:
    def find_spec(self, name, path=None, target=None):
        if ".kernels." in name:
            file = pathlib.Path(path[0]) / (name.rpartition(".")[2] + ".py")
            return importlib.util.spec_from_file_location(name, file)

sys.meta_path.insert(0, Sources())
"""
"""Code after which kernels are imported from their sources."""

RUN = """
import hashlib, pathlib, random, sys, tempfile
import floorplan, navigation, sim
from navigation import quadrature
from navigation.kernels import COMPILED

print(COMPILED, file=sys.stderr)
digest = hashlib.sha256()
rng = random.Random(3)
place = lambda: (rng.uniform(-4, 4), rng.uniform(-4, 4))
laws = (
    navigation.SeparationLaw(t1=1.0, t2=1.5, intrusion=1.0),
    navigation.IntegralLaw(t1=0.5, t2=1.0, intrusion=0.3),
    navigation.Scaled(navigation.IntegralLaw(t1=0.5, t2=1.0), 1.5, cap=1.2),
    navigation.FixedDistance(1.0),
)
shapes = navigation.Shapes(
    machine=(navigation.Box(length=1.05, width=0.95, bottom=1.2, top=2.7),
             navigation.Cylinder(radius=1.2, bottom=1.9, top=2.7))
)
stops = navigation.gantry_stops(), navigation.agv_stops(floorplan.load("ariac2023").lane("agv1"))
for _ in range(40):
    person = navigation.walk([place() for _ in range(4)], rng.uniform(0, 3))
    digest.update(repr([*navigation.stop_walking(person, person.end / 2).table]).encode())
    machine = navigation.gantry_move((*place(), 0.0), (*place(), rng.uniform(-3, 3)), 1.0)
    pair = (person, machine)
    people = [c for _ in range(3) for c in (*place(), 1.5, rng.choice((-1.0, 2.0)))]
    away = navigation.nearest_on(machine.table, people, 2.0, 2.0, 9.0, 0.5, 5.0)
    digest.update(repr(away).encode())
    places = [c for _ in range(9) for c in place()]
    remote = navigation.most_remote(places, people, [0.0, 1.0, 2.0], 1.5, 1.0, 0.5, 3.0)
    digest.update(repr(remote).encode())
    for law in laws:
        for stop in stops if hasattr(law, "distance") else ():
            horizon = navigation.StoppingHorizon(law, 0.01)
            found = horizon.safe_until(machine.table, stop, people, 2.0, 0.2)
            digest.update(repr((found, [*stop.table(machine.table, 3.0)])).encode())
        for solids in (None, shapes):
            digest.update(repr((
                navigation.violations(*pair, law, 0.0, 20.0, shapes=solids),
                navigation.minimum_margin(*pair, law, 0.0, 20.0, shapes=solids),
                navigation.minimum_separation(*pair, 0.0, 20.0, shapes=solids),
            )).encode())
for name in ("ariac2023", "people_aisle"):
    with tempfile.TemporaryDirectory() as folder:
        recording = sim.Recording(pathlib.Path(folder))
        recording.finish(sim.run(sim.Trial.load(name), recording))
        for file in ("events.jsonl", "motions.jsonl", "trajectory.csv"):
            digest.update(pathlib.Path(folder, file).read_bytes())
world = navigation.CollisionWorld(floorplan.load("ariac2023"))
planner = navigation.PathPlanner(world, 0.3)
for _ in range(30):
    for lane in world.plan.lanes:
        world.move_agv(lane.name, rng.uniform(*lane.limits))
    ends = [(rng.uniform(-22, 2), rng.uniform(-12, 12)) for _ in range(2)]
    try:
        digest.update(planner.plan(*ends).points.tobytes())
    except navigation.PlanningError as why:
        digest.update(why.reason.encode())
print(digest.hexdigest())
"""


@pytest.mark.slow
@pytest.mark.skipif(not COMPILED, reason="the kernels are not compiled here")
def test_results_are_the_same_compiled_and_not(tmp_path):
    runs = [
        subprocess.run(
            [sys.executable, "-c", before + RUN],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
        )
        for before in ("", AS_PYTHON)
    ]
    assert [run.stderr for run in runs] == ["True\n", "False\n"]
    assert runs[0].stdout == runs[1].stdout


@pytest.mark.parametrize("n", [5, 8])
def test_quadratures_are_gauss_and_legendres(n):
    nodes, weights = np.polynomial.legendre.leggauss(n)
    assert getattr(quadrature, f"NODES_{n}") == pytest.approx(nodes, rel=1e-15, abs=1e-16)
    assert getattr(quadrature, f"WEIGHTS_{n}") == pytest.approx(weights, rel=1e-14)
