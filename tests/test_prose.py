"""Pages, docstrings and comments are plain sentences."""

from itertools import chain
from pathlib import Path

import pytest
from prose import MEASURES, of_module, of_page, shares

ROOT = Path(__file__).resolve().parents[1]

LIMITS = (2.0, 0.5, 1.5)
"""Limits of all rooms, in the order of `MEASURES`."""

HIGHER = {
    "bdi": (2.0, 1.0, 1.5),
    "bdi/internal_actions": (11.3, 1.2, 3.5),
    "bdi/language": (8.9, 1.7, 4.6),
    "bdi/reasoning": (10.3, 1.4, 3.3),
    "floorplan": (4.5, 0.5, 1.5),
    "floorplan/files": (10.9, 2.5, 3.4),
    "floorplan/formats": (14.5, 1.4, 2.7),
    "navigation": (3.6, 1.5, 3.2),
    "navigation/benchmark": (9.6, 0.6, 1.5),
    "navigation/kernels": (11.1, 3.7, 6.9),
    "sim": (2.0, 1.0, 12.4),
    "sim/bridge": (15.1, 0.5, 7.0),
    "sim/core": (3.0, 0.5, 2.9),
    "sim/gym": (5.2, 1.3, 1.5),
    "sim/live": (7.0, 0.5, 6.5),
    "sim/machines/amr": (2.0, 0.7, 1.5),
    "sim/people": (16.7, 4.4, 16.3),
    "sim/people/crowd": (5.3, 2.5, 10.1),
    "sim/people/tracks": (13.4, 0.5, 7.3),
    "sim/runs": (9.1, 1.6, 6.9),
    "sim/safety": (9.9, 4.7, 10.9),
    "sim/trials": (9.7, 1.6, 11.6),
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
    found = shares(chain.from_iterable(map(of_module, sorted((ROOT / room).glob("*.py")))))
    limits = HIGHER.get(room, LIMITS)
    above = [one for one in zip(MEASURES, found, limits, strict=True) if one[1] > one[2]]
    assert not above, f"python -m tests.prose {room} prints the sentences"


def test_pages_are_plain_sentences():
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    found = shares(chain.from_iterable(map(of_page, pages)))
    assert all(share <= limit for share, limit in zip(found, LIMITS, strict=True)), found
