"""Makes all published tables and pictures again that do not depend on the machine.

    python docs/published.py [NAME …]

Fails and names what differs, if anything does. The documents then have the new tables and pictures,
so `git diff` shows what has changed. NAME is one or more of `PUBLISHED`, by default all of them.

Screenshots of pages (`make_screens.py`) depend on the browser and its fonts, and times on the
processor: they are not made here.
"""

from __future__ import annotations

import importlib
import re
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import make_pictures
import make_tables
import numpy as np
from PIL import Image, ImageSequence

import floorplan
import sim
from navigation import planners
from navigation.benchmark import PlannerRow, benchmark, summary

DOCS = Path(__file__).resolve().parent
EXAMPLES = DOCS.parent / "examples"
JOBS = 2
"""Processes. The results do not depend on them."""

SVG_TOLERANCE = 0.02
"""Points. Coordinates in an SVG may differ by so much."""

PIXEL_TOLERANCE = 8
"""Of 255. Pixels that differ by less are the same."""

SHARE = 0.001
"""The share of pixels that may differ."""


@dataclass(frozen=True)
class Published:
    """Tables and pictures that are made together.

    `make` gets the folder for the pictures and returns the tables by name.
    """

    make: Callable[[Path], Mapping[str, str]]
    tables: tuple[str, ...] = ()
    pictures: tuple[str, ...] = ()


def _of_benchmark(name: str) -> Any:
    """Return a module of the folder `benchmarks`."""
    folder = str(DOCS.parent / "benchmarks")
    if folder not in sys.path:
        sys.path.append(folder)
    return importlib.import_module(name)


def reference(_: Path) -> dict[str, str]:
    """Make the tables that follow from the code."""
    return {name: make() for name, make in make_tables.TABLES.items()}


def pictures(folder: Path) -> dict[str, str]:
    """Make the plots."""
    for make in make_pictures.ALL:
        make(folder)
    return {}


def competitor(folder: Path) -> dict[str, str]:
    """Run the competitor's study."""
    made = _of_benchmark("competitor")
    study = sim.Study.load(EXAMPLES / "competitor.study.yaml")
    with TemporaryDirectory() as out:
        sim.run_study(study, out, jobs=JOBS)
        rows = made.rows_of(Path(out) / "results.csv")
    made.picture(rows, folder / "competitor.png")
    return {"competitor": made.table(rows)}


def controllers(_: Path) -> dict[str, str]:
    """Run the gantry controllers beside each personality."""
    return {"controllers": _of_benchmark("controllers").table(trials=100, jobs=JOBS)}


def literature(folder: Path) -> dict[str, str]:
    """Walk the scenes of the literature."""
    made = _of_benchmark("literature")
    return {"literature": made.published(1000, folder / "literature.svg")}


def crowds(_: Path) -> dict[str, str]:
    """Run the random crowds."""
    return {"crowds": _of_benchmark("random_crowds").table(range(1000), every=5, jobs=JOBS)}


def legs(_: Path) -> dict[str, str]:
    """Count the legs that crowds on patrol finish."""
    return {"legs": _of_benchmark("people").legs((1, 10, 50, 100))}


PEERS = ("JuPedSim", "pyastar2d", "scikit-image")


def paths(_: Path) -> dict[str, str]:
    """Compare all planners on the floor of the competition."""
    asked = ["Roadmap", "PRM-of-corners"]
    asked += [info.name for info in planners() if info.name not in asked]
    plan = floorplan.load("ariac2023")
    attempts = benchmark([plan], [*asked, *PEERS], queries=50, longest=1.5)
    return {"paths_ariac2023": _paths(summary(attempts))}


def _paths(rows: list[PlannerRow]) -> str:
    head = "planner", "solved", "wrong", "length ÷ shortest, median", "at most"
    lines = [
        (
            row.planner,
            f"{100 * row.solved.value:.0f} % ({100 * row.solved.low:.0f} …"
            f" {100 * row.solved.high:.0f})",
            row.faults or "0",
            f"{row.ratio.value:.4f}",
            f"{row.ratio_most:.4f}",
        )
        for row in rows
    ]
    return make_tables.table(head, lines)


PUBLISHED = {
    "reference": Published(reference, tuple(make_tables.TABLES)),
    "pictures": Published(
        pictures,
        pictures=(
            *(f"tutorial-{one}.svg" for one in ("first", "way", "trails", "before", "after")),
            *(f"plot-{one}.svg" for one in ("floorplan", "path", "trails", "spacetime")),
            *("plot-separation.svg", "plot-heatmap.svg", "avoidance-candidates.svg"),
            *(f"{scene.replace('_', '-')}.svg" for scene in make_pictures.SCENES),
        ),
    ),
    "competitor": Published(competitor, ("competitor",), ("competitor.png",)),
    "controllers": Published(controllers, ("controllers",)),
    "literature": Published(literature, ("literature",), ("literature.svg",)),
    "crowds": Published(crowds, ("crowds",)),
    "legs": Published(legs, ("legs",)),
    "paths": Published(paths, ("paths_ariac2023",)),
}
"""All that is published and does not depend on the machine."""


def differ(one: Path, other: Path) -> bool:
    """Return whether two pictures of a kind show something else."""
    if one.read_bytes() == other.read_bytes():
        return False
    if one.suffix == ".svg":
        return _drawings_differ(*(path.read_text(encoding="utf-8") for path in (one, other)))
    with Image.open(one) as a, Image.open(other) as b:
        frames = [
            [np.asarray(frame.convert("RGB"), int) for frame in ImageSequence.Iterator(image)]
            for image in (a, b)
        ]
    if [frame.shape for frame in frames[0]] != [frame.shape for frame in frames[1]]:
        return True
    return any(
        (np.abs(f - g).max(axis=2) > PIXEL_TOLERANCE).mean() > SHARE
        for f, g in zip(*frames, strict=True)
    )


_NUMBER = re.compile(r"(?<![\w#.])-?\d+(?:\.\d+)?")


def _drawings_differ(one: str, other: str) -> bool:
    if _NUMBER.sub("", one) != _NUMBER.sub("", other):
        return True
    figures = (np.array(_NUMBER.findall(text), float) for text in (one, other))
    return bool((np.abs(np.subtract(*figures)) > SVG_TOLERANCE).any())


def publish(names: list[str]) -> list[str]:
    """Make these again, write what differs into the documents, and return its names."""
    changed = []
    for name in names:
        published, begin = PUBLISHED[name], time.monotonic()
        with TemporaryDirectory() as out:
            tables = published.make(Path(out))
            for picture in published.pictures:
                made, there = Path(out) / picture, DOCS / "images" / picture
                if not there.is_file() or differ(made, there):
                    there.write_bytes(made.read_bytes())
                    changed.append(f"docs/images/{picture}")
        for page in sorted(DOCS.glob("*.md")):
            text = before = page.read_text(encoding="utf-8")
            for table, made in tables.items():
                fresh = make_tables.with_tables(text, {table: lambda made=made: made})
                if fresh != text:
                    changed.append(f"docs/{page.name}: table {table}")
                    text = fresh
            if text != before:
                page.write_text(text, encoding="utf-8")
        print(f"{name}: {time.monotonic() - begin:.0f} s", flush=True)
    return changed


def main() -> None:
    """Recreate the selected parts. Exit with 1 if anything differs."""
    names = sys.argv[1:] or [*PUBLISHED]
    if unknown := [name for name in names if name not in PUBLISHED]:
        sys.exit(f"nothing is called {unknown[0]!r}; there are: {', '.join(PUBLISHED)}")
    if changed := publish(names):
        sys.exit("\n".join(["not as published (the documents have the new ones):", *changed]))


if __name__ == "__main__":
    main()
