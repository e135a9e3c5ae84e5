"""Makes the pictures of the documents: `python docs/make_pictures.py [FOLDER]`.

The pictures of the tutorial come from the files in the tutorial.
"""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from make_candidates import candidates

import floorplan
import sim
from navigation import CollisionWorld, PathPlanner
from sim.views import plots

DOCS = Path(__file__).resolve().parent
NAMED_BLOCK = re.compile(
    r"`([\w.]+\.(?:yaml|asl|py))`[^\n]*\n(?:[^\n]+\n){0,2}\n```\w+\n(.*?)```", re.S
)


def files_of(document: Path, folder: Path) -> None:
    """Write the files that a document shows, each under the name before it, into `folder`."""
    for name, text in NAMED_BLOCK.findall(document.read_text(encoding="utf-8")):
        (folder / name).write_text(text, encoding="utf-8")


def tutorial(out: Path) -> None:
    """The pictures that a reader of the tutorial sees."""
    first = sim.run(sim.Trial.load("ariac2023"))
    plots.save(first.plot.separation(within=(0.0, 90.0)), out / "tutorial-first.svg")
    with TemporaryDirectory() as name:
        folder = Path(name)
        files_of(DOCS / "tutorial.md", folder)
        world = CollisionWorld(floorplan.load(folder / "room.yaml"))
        path = PathPlanner(world).plan((1.0, 1.0), (12.0, 7.5))
        plots.save(plots.path(world, path, radius=0.3), out / "tutorial-way.svg")
        trial = sim.Trial.load(folder / "room.trial.yaml")
        polite = sim.run(trial.with_personality("polite.asl"))
        plots.save(polite.plot.trails(), out / "tutorial-trails.svg")
        courteous = replace(trial, gantry=replace(trial.gantry, controller="courteous:courteous"))
        for name, chosen in (("before", trial), ("after", courteous)):
            plots.save(sim.run(chosen).plot.separation(), out / f"tutorial-{name}.svg")


def gallery(out: Path) -> None:
    """One picture of each kind, for the page about pictures."""
    plots.save(plots.floorplan(floorplan.load("warehouse")), out / "plot-floorplan.svg")
    world = CollisionWorld(floorplan.load("machine_shop"))
    path = PathPlanner(world).plan((16.8, 6.0), (4.0, 13.5))
    plots.save(plots.path(world, path, radius=0.25), out / "plot-path.svg")
    run = sim.run(sim.Trial.load(DOCS.parent / "examples" / "two_people.trial.yaml"))
    plots.save(run.plot.trails(), out / "plot-trails.svg")
    plots.save(run.plot.space_time(), out / "plot-spacetime.svg")
    plots.save(run.plot.separation(), out / "plot-separation.svg")
    plots.save(run.plot.heat_map(), out / "plot-heatmap.svg")


SCENES = {
    "people_frontal": 22.0,
    "people_overtaking": 28.0,
    "people_crossing": 12.0,
    "people_corner": 26.0,
    "people_door": 14.0,
    "people_aisle": 24.0,
    "people_counterflow": 26.0,
    "people_group": 26.0,
    "people_queue": 30.0,
    "people_bottleneck": 28.0,
    "people_parallel": 36.0,
    "people_perpendicular": 20.0,
    "people_blind_spot": 12.0,
}
"""The scenes among people, and how much of each (seconds) its picture shows."""


def scenes(out: Path) -> None:
    """The paths of people in the scenes that come with Floorwalker."""
    for name, end in SCENES.items():
        run = sim.run(sim.Trial.load(name))
        figure = run.plot.trails(within=(0.0, end))
        plots.save(figure, out / f"{name.replace('_', '-')}.svg")


ALL = (tutorial, gallery, scenes, candidates)
"""Functions that make all pictures into a folder."""


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else DOCS / "images"
    for make in ALL:
        make(folder)
