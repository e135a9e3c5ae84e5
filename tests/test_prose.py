"""Pages, docstrings and comments are plain sentences."""

from itertools import chain
from pathlib import Path

import pytest
from prose import MEASURES, of_module, of_page, shares

ROOT = Path(__file__).resolve().parents[1]

LIMITS = (2.0, 0.5, 1.5)
"""Limits of all rooms, in the order of `MEASURES`."""

HIGHER = {
    "floorplan/files": (2.0, 0.6, 1.5),
    "sim": (2.0, 0.5, 1.8),
    "sim/cell": (2.0, 0.5, 1.6),
    "sim/machines/amr": (2.0, 0.7, 1.5),
    "sim/ros2": (2.0, 1.9, 5.5),
    "sim/safety": (2.0, 1.5, 1.5),
}
"""Limits of rooms that exceed them."""

ROOMS = sorted(
    {
        path.parent.relative_to(ROOT).as_posix()
        for package in ("floorplan", "navigation", "bdi", "sim")
        for path in (ROOT / package).rglob("*.py")
    }
)


@pytest.mark.parametrize("room", ROOMS)
def test_docstrings_and_comments_are_plain_sentences(room):
    measured = shares(chain.from_iterable(map(of_module, sorted((ROOT / room).glob("*.py")))))
    limits = HIGHER.get(room, LIMITS)
    above = [one for one in zip(MEASURES, measured, limits, strict=True) if one[1] > one[2]]
    assert not above, f"python -m tests.prose {room} prints the sentences"


def test_pages_are_plain_sentences():
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    measured = shares(chain.from_iterable(map(of_page, pages)))
    assert all(share <= limit for share, limit in zip(measured, LIMITS, strict=True)), measured
