"""How long a DXF drawing of many entities takes to load, the first time and again: CPU seconds.

    python benchmarks/big_drawings.py [--entities 20000] [--runs 3]

A hall as CAD has it, in millimetres: machines as closed polylines, walls of single lines whose ends
miss each other by up to 5 mm, rounded tables of lines and arcs, tanks, splines, hatched areas,
racks as blocks that are turned, scaled and mirrored and have blocks in them, and texts. Each run is
in a fresh process, imports included. Medians are printed.
"""

from __future__ import annotations

import argparse
import math
import random
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

SPACING = 3000.0
"""Millimetres from one thing to the next."""

SLIP = 2.0
"""Millimetres. So far off its place the end of a line is drawn, to either side."""

FLOOR = """\
base: {drawing}
units: mm
snap: 0.02
layers:
  boundary: [HALL]
  walls: ["A-WALL*"]
  machines: ["M-*"]
  racks: [RACK*]
  floor: {{layers: [MARK], z: [0, 0.1]}}
"""


def draw(path: Path, entities: int) -> None:
    """Write a drawing with this number of entities."""
    import ezdxf

    rng = random.Random(entities)
    drawing = ezdxf.new("R2018", units=ezdxf.units.MM)
    space = drawing.modelspace()
    _blocks(drawing)
    kinds = [_box, _room, _table, _tank, _blob, _mark, _rack, _rack, _text, _text]
    across = math.ceil(math.sqrt(entities))
    side = across * SPACING
    outline = [(0, 0), (side, 0), (side, side), (0, side)]
    space.add_lwpolyline(outline, close=True, dxfattribs={"layer": "HALL"})
    cell = 0
    while len(space) < entities:
        x, y = ((at + 0.5) * SPACING for at in (cell % across, cell // across))
        rng.choice(kinds)(space, rng, x, y)
        cell += 1
    drawing.saveas(path)


def _blocks(drawing: Any) -> None:
    bay = drawing.blocks.new("BAY")
    bay.add_lwpolyline([(0, 0), (900, 0), (900, 400), (0, 400)], close=True)
    rack = drawing.blocks.new("RACK")
    for k in range(2):
        rack.add_blockref("BAY", (-450, 450 * k), dxfattribs={"xscale": 1 + k})
    rack.add_text("R", dxfattribs={"layer": "TEXT"})


def _box(space: Any, rng: random.Random, x: float, y: float) -> None:
    w, d = rng.uniform(300, 900), rng.uniform(300, 900)
    corners = [(x - w, y - d), (x + w, y - d), (x + w, y + d), (x, y + d / 2), (x - w, y + d)]
    space.add_lwpolyline(corners, close=True, dxfattribs={"layer": "M-PRESS"})


def _room(space: Any, rng: random.Random, x: float, y: float) -> None:
    corners = [(x - 900, y - 900), (x + 900, y - 900), (x + 900, y + 900), (x - 900, y + 900)]
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        ends = [[c + rng.uniform(-SLIP, SLIP) for c in end] for end in (a, b)]
        space.add_line(*ends, dxfattribs={"layer": f"A-WALL-{rng.randrange(4)}"})


def _table(space: Any, rng: random.Random, x: float, y: float) -> None:
    look, r, w = {"layer": "M-TABLE"}, 300, rng.uniform(400, 900)
    space.add_line((x - w, y - r), (x + w, y - r), dxfattribs=look)
    space.add_arc((x + w, y), r, -90, 90, dxfattribs=look)
    space.add_line((x + w, y + r), (x - w, y + r), dxfattribs=look)
    space.add_arc((x - w, y), r, 90, 270, dxfattribs=look)


def _tank(space: Any, rng: random.Random, x: float, y: float) -> None:
    space.add_circle((x, y), rng.uniform(300, 1000), dxfattribs={"layer": "M-TANK"})


def _blob(space: Any, rng: random.Random, x: float, y: float) -> None:
    around = [2 * math.pi * k / 8 for k in range(8)]
    out = [rng.uniform(400, 1000) for _ in around]
    points = [(x + r * math.cos(a), y + r * math.sin(a)) for a, r in zip(around, out, strict=True)]
    space.add_spline([*points, points[0]], dxfattribs={"layer": "M-VESSEL"})


def _mark(space: Any, rng: random.Random, x: float, y: float) -> None:
    hatch = space.add_hatch(dxfattribs={"layer": "MARK"})
    for half in (1000, 500):
        corners = [(x - half, y - half), (x + half, y - half), (x + half, y + half)]
        hatch.paths.add_polyline_path([*corners, (x - half, y + half)], is_closed=True)


def _rack(space: Any, rng: random.Random, x: float, y: float) -> None:
    scale = rng.choice([-1.0, 1.0])
    look = {"layer": "RACK", "rotation": rng.choice([0, 90, 30]), "xscale": scale}
    space.add_blockref("RACK", (x, y), dxfattribs=look)


def _text(space: Any, rng: random.Random, x: float, y: float) -> None:
    space.add_text(f"{rng.random():.3f}", dxfattribs={"layer": "TEXT"}).set_placement((x, y))


def measure(path: Path) -> None:
    begin = time.process_time()
    import floorplan

    plan = floorplan.load(path)
    loaded = time.process_time()
    assert floorplan.load(path) == plan
    print(len(plan.obstacles), loaded - begin, time.process_time() - loaded)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--entities", type=int, nargs="+", default=[20_000])
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--one", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        measure(options.one)
        return
    print("| entities | obstacles | load, s | load again, s |")
    print("|---|---|---|---|")
    for count in options.entities:
        with tempfile.TemporaryDirectory() as folder:
            draw(Path(folder, "hall.dxf"), count)
            floor = Path(folder, "hall.yaml")
            floor.write_text(FLOOR.format(drawing="hall.dxf"), encoding="utf-8")
            again = [sys.executable, __file__, "--one", str(floor)]
            runs = [
                [float(figure) for figure in subprocess.check_output(again, text=True).split()]
                for _ in range(options.runs)
            ]
            median = [statistics.median(column) for column in zip(*runs, strict=True)]
            seconds = " | ".join(f"{figure:.2f}" for figure in median[1:])
            print(f"| {count:,} | {median[0]:,.0f} | {seconds} |", flush=True)


if __name__ == "__main__":
    main()
