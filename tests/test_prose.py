"""Pages, docstrings and comments are plain sentences."""

from itertools import chain
from pathlib import Path

import pytest
from prose import MEASURES, of_module, of_page, shares

ROOT = Path(__file__).resolve().parents[1]

LIMITS = (2.0, 0.5, 1.5)
"""Limits of all rooms, in the order of `MEASURES`."""

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
    above = [one for one in zip(MEASURES, measured, LIMITS, strict=True) if one[1] > one[2]]
    assert not above, f"python -m tests.prose {room} prints the sentences"


def test_pages_are_plain_sentences():
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    measured = shares(chain.from_iterable(map(of_page, pages)))
    assert all(share <= limit for share, limit in zip(measured, LIMITS, strict=True)), measured
