"""Raster maps: grey images as arrays, and polygons traced around their cells."""

from __future__ import annotations

import io
import re
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from ..files.dataclass import dataclass
from ..files.problems import FloorplanError, UserError
from ..files.reading import read_bytes

if TYPE_CHECKING:
    from PIL.Image import Image


MOST_CELLS = 64_000_000
"""Maximum number of pixels. At 0.05 m, 8,000 × 8,000 are 400 m × 400 m."""

LARGEST_FILE = 2 * MOST_CELLS + 65_536
"""Bytes of an image with the maximum number of pixels of 16 bits, and its header."""

FORMATS = ("PNG", "BMP", "GIF", "JPEG", "PPM")
"""Image formats that Pillow may try. PPM includes all formats of Netpbm."""

Levels: TypeAlias = "NDArray[np.uint8] | NDArray[np.uint16]"

_PGM_HEADER = rb"(P[25])" + rb"(?:\s|#[^\n]*\n)+(\d{1,20})" * 3 + rb"(?:#[^\n]*\n)?\s"


@dataclass(frozen=True)
class GreyImage:
    """Brightness from 0 (black) to `top` (white), (rows, columns), the top row first.

    `opaque` marks the pixels that are not transparent, or is None if all are opaque.
    """

    levels: Levels
    opaque: NDArray[np.bool_] | None
    top: int


def read_image(path: Path) -> GreyImage:
    """Return the grey image at `path`. `FloorplanError` if it cannot be used."""
    data = read_bytes(path, FloorplanError, LARGEST_FILE)
    return _read_pgm(data, path) if data[:2] in (b"P2", b"P5") else _read_other(data, path)


def _read_pgm(data: bytes, path: Path) -> GreyImage:
    header = re.match(_PGM_HEADER, data)
    if header is None:
        raise FloorplanError.of(path, "is not a PGM image: its header is broken")
    kind = header.group(1)
    width, height, top = (int(part) for part in header.groups()[1:])
    _check_size(width, height, path)
    if not 0 < top < 65536:
        raise FloorplanError.of(path, f"is not a PGM image: its white is {top}")
    count, begin = width * height, header.end()
    levels: Levels
    if kind == b"P5":
        size = 2 if top > 255 else 1
        there = min(count, (len(data) - begin) // size)
        if size == 2:
            levels = np.frombuffer(data, ">u2", there, begin).astype(np.uint16)
        else:
            levels = np.frombuffer(data, np.uint8, there, begin)
    else:
        levels = _plain_numbers(data[begin:], count, top, path)
    if len(levels) < count:
        raise FloorplanError.of(path, f"is cut short: {len(levels)} of {count} pixels")
    # Brighter values count as white.
    return GreyImage(np.minimum(levels, top).reshape(height, width), None, top)


def _plain_numbers(body: bytes, count: int, top: int, path: Path) -> NDArray[np.uint16]:
    """Return the first `count` numbers in the text of a plain PGM, or all if there are fewer."""
    if b"#" in body:
        body = re.sub(rb"#[^\n]*", b"", body)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", DeprecationWarning)  # end of the numbers for older NumPy
            numbers = np.fromstring(body, float, count, sep=" ") if body.strip() else np.empty(0)
    except (DeprecationWarning, ValueError):
        raise FloorplanError.of(path, "is not a PGM image: something in it is no number") from None
    if not ((numbers >= 0) & (numbers <= top)).all():
        raise FloorplanError.of(path, f"is not a PGM image: a number in it is not from 0 to {top}")
    return numbers.astype(np.uint16)


def _read_other(data: bytes, path: Path) -> GreyImage:
    if data[:4] in (b"II*\0", b"MM\0*"):
        raise FloorplanError.of(path, "is a TIFF, which is not supported: convert it to PNG or PGM")
    try:
        from PIL import Image, UnidentifiedImageError
    except ImportError:
        message = (
            "only PGM images can be read without Pillow; pip install 'floorwalker[floorplans]'"
        )
        raise FloorplanError.of(path, message) from None
    # The size is checked here, because Pillow warns of large images or rejects them.
    limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
    try:
        with Image.open(io.BytesIO(data), formats=FORMATS) as image:
            _check_size(*image.size, path)
            return _grey(image, path)
    except UnidentifiedImageError:
        raise FloorplanError.of(path, "is not an image") from None
    except FloorplanError:
        raise
    except (OSError, SyntaxError, ValueError) as why:
        raise FloorplanError.of(path, f"can't be read: {why}") from None
    finally:
        Image.MAX_IMAGE_PIXELS = limit


def _grey(image: Image, path: Path) -> GreyImage:
    if image.mode.startswith("I"):
        return GreyImage(np.asarray(image).astype(np.uint16), None, 65535)
    if image.mode in ("1", "L") and "transparency" not in image.info:
        return GreyImage(np.asarray(image.convert("L")), None, 255)
    bands = image.convert("RGBA")
    red, green, blue, alpha = (np.asarray(bands.getchannel(k)) for k in range(4))
    if (red != green).any() or (red != blue).any():
        raise FloorplanError.of(path, "is in colour; a map is grey")
    return GreyImage(red, alpha == 255, 255)


def _check_size(width: int, height: int, path: Path) -> None:
    if width * height == 0:
        raise FloorplanError.of(path, "has no pixels")
    if width * height > MOST_CELLS:
        message = (
            f"has {width} × {height} pixels; at most {MOST_CELLS:,} can be read:"
            " give a map of a coarser resolution, or a part of it"
        )
        raise FloorplanError.of(path, message)


MOST_CORNERS = 1_000_000
"""Maximum number of corners of all outlines. The walls of a large hall have some 10,000."""

MOST_OUTLINES = 100_000
"""Maximum number of outlines, because planning among more obstacles takes too long."""

_INSET = 0.125
"""Cells. Distance of a ring from a corner at which two of its cells touch diagonally."""

Ints = NDArray[np.int64]

Rings: TypeAlias = NDArray[np.object_]
"""Closed lines (shapely)."""


class IntricateError(UserError):
    """Cells with more outlines than can be handled."""


def trace(cells: NDArray[np.bool_], tolerance: float) -> shapely.Geometry:
    """Return the area of the set cells of the mask `cells`, shape (rows, columns).

    Cell [r, c] covers x from c to c + 1 and y from r to r + 1. Cells that touch only at a corner
    stay apart. Simplified rings deviate by at most `tolerance` cells. `IntricateError` if there are
    more than `MOST_OUTLINES` rings or `MOST_CORNERS` corners.
    """
    shells, holes = _rings(np.pad(cells, 1))
    if (count := len(shells) + len(holes)) > MOST_OUTLINES:
        raise IntricateError(f"{count:,} outlines, of at most {MOST_OUTLINES:,}")
    # Rings are on borders of cells and apart at diagonal corners, so the polygons are valid by
    # construction.
    area = shapely.multipolygons(_polygons(shells, holes))
    return shapely.simplify(area, tolerance, preserve_topology=True) if tolerance else area


def _polygons(shells: Rings, holes: Rings) -> NDArray[np.object_]:
    """Return each shell with its holes. A hole belongs to the smallest shell around it."""
    polygons: NDArray[np.object_] = shapely.polygons(shells)
    tree = shapely.STRtree(shapely.get_point(holes, 0))
    around, inside = tree.query(polygons, predicate="contains")
    # The smallest shell around a hole comes first, and `unique` returns the first for each hole.
    inner_first = np.argsort(shapely.area(polygons)[around], kind="stable")
    _, first = np.unique(inside[inner_first], return_index=True)
    owner = around[inner_first][first]
    by_owner = np.argsort(owner, kind="stable")
    owners, begin = np.unique(owner[by_owner], return_index=True)
    for shell, rings in zip(owners, np.split(holes[by_owner], begin[1:]), strict=False):
        polygons[shell] = shapely.polygons(shells[shell], rings)
    return polygons


def _rings(cells: NDArray[np.bool_]) -> tuple[Rings, Rings]:
    """Return the closed outlines around cells and holes, through their corners.

    In each row, sorted corners pair up into the horizontal sides of outlines, and in each column
    into the vertical sides. The sides are then chained.
    """
    row, column, second, point = _corners(cells)
    count = len(row)
    # Sorted by row, then column: every other corner begins a side, and the next one ends it.
    across = _pairs(count, np.lexsort((np.arange(count), column, row)))
    # At a diagonal corner the first of two copies ends the left side, the second begins the right
    # one. Along the column, the copy around the cell above comes first.
    lower = cells[row, column] == second
    along = _pairs(count, np.lexsort((lower, row, column)))
    across_list, along_list = across.tolist(), along.tolist()
    done = bytearray(count)
    chain: list[int] = []
    begins: list[int] = []
    for first in range(count):
        if done[first]:
            continue
        begins.append(len(chain))
        here = first
        while not done[here]:
            there = across_list[here]
            chain += [here, there]
            done[here] = done[there] = True
            here = along_list[there]
    of = np.repeat(np.arange(len(begins)), np.diff([*begins, len(chain)]))
    rings = shapely.linearrings(point[chain], indices=of)
    # The inside of an outline is below and right of its first corner, in the order of rows.
    starts = np.array(chain, dtype=np.intp)[begins]
    is_shell = cells[row[starts] + 1, column[starts] + 1]
    return rings[is_shell], rings[~is_shell]


def _corners(
    cells: NDArray[np.bool_],
) -> tuple[Ints, Ints, NDArray[np.bool_], NDArray[np.float64]]:
    """Return the corners of outlines: row, column, whether it is the second copy, and position.

    Corners at which two cells touch diagonally occur twice.
    """
    above_left, above_right = cells[:-1, :-1], cells[:-1, 1:]
    below_left, below_right = cells[1:, :-1], cells[1:, 1:]
    diagonal = (above_left == below_right) & (above_right == below_left)
    diagonal &= above_left != above_right
    # An outline has a corner if one or three of the four cells around it are set.
    odd = above_left ^ above_right ^ below_left ^ below_right
    odd |= diagonal
    if (count := np.count_nonzero(odd)) > MOST_CORNERS:
        raise IntricateError(f"outlines of {count:,} corners, of at most {MOST_CORNERS:,}")
    row, column = np.nonzero(odd)
    twice = diagonal[row, column]
    row, column = np.repeat(row, 1 + twice), np.repeat(column, 1 + twice)
    twice = np.repeat(twice, 1 + twice)
    second = np.zeros(len(row), bool)
    second[1:] = twice[1:] & (row[1:] == row[:-1]) & (column[1:] == column[:-1])
    # Move each copy towards its set cell.
    sideways = np.where(second, _INSET, -_INSET) * twice
    upright = np.where(above_left[row, column] == second, _INSET, -_INSET) * twice
    # Corner [r, c] lies between the cells r and r + 1 of the padded grid: at y = r unpadded.
    point = np.column_stack([column + sideways, row + upright]).astype(float)
    return row, column, second, point


def _pairs(count: int, order: NDArray[np.intp]) -> Ints:
    """Return the index of the partner of each corner, if successive corners are pairs."""
    partner = np.empty(count, np.int64)
    partner[order[0::2]], partner[order[1::2]] = order[1::2], order[0::2]
    return partner
