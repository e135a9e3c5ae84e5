"""Grey images as arrays: PGM without further packages, others of map_server's through Pillow."""

from __future__ import annotations

import io
import re
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .problems import FloorplanError
from .reading import read_bytes

if TYPE_CHECKING:
    from PIL.Image import Image

MOST_CELLS = 64_000_000
"""Images with more pixels are refused: 8,000 × 8,000 are 400 m × 400 m at 0.05 m, where a floor of
50 m × 50 m takes 1,000,000."""

LARGEST_FILE = 2 * MOST_CELLS + 65_536
"""Bytes: those of as many pixels of 16 bits, and of a header."""

FORMATS = ("PNG", "BMP", "GIF", "JPEG", "PPM")
"""Formats that Pillow may try; PPM stands for all of Netpbm's."""

Levels: TypeAlias = "NDArray[np.uint8] | NDArray[np.uint16]"

_PGM_HEADER = rb"(P[25])" + rb"(?:\s|#[^\n]*\n)+(\d{1,20})" * 3 + rb"(?:#[^\n]*\n)?\s"


@dataclass(frozen=True)
class GreyImage:
    """Brightness from 0 (black) to `top` (white), (rows, columns), the top row first.

    `opaque` marks the pixels that are not transparent; None if all are.
    """

    levels: Levels
    opaque: NDArray[np.bool_] | None
    top: int


def read_image(path: Path) -> GreyImage:
    """Return the grey image at `path`; `FloorplanError` says why it can't be used."""
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
    # What is brighter than white is white.
    return GreyImage(np.minimum(levels, top).reshape(height, width), None, top)


def _plain_numbers(body: bytes, count: int, top: int, path: Path) -> NDArray[np.uint16]:
    """Return the first `count` numbers in the text of a plain PGM, or all if they are fewer."""
    if b"#" in body:
        body = re.sub(rb"#[^\n]*", b"", body)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", DeprecationWarning)  # so older NumPy ends
            found = np.fromstring(body, float, count, sep=" ") if body.strip() else np.empty(0)
    except (DeprecationWarning, ValueError):
        raise FloorplanError.of(path, "is not a PGM image: something in it is no number") from None
    if not ((found >= 0) & (found <= top)).all():
        raise FloorplanError.of(path, f"is not a PGM image: a number in it is not from 0 to {top}")
    return found.astype(np.uint16)


def _read_other(data: bytes, path: Path) -> GreyImage:
    try:
        from PIL import Image, UnidentifiedImageError
    except ImportError:
        message = (
            "only PGM images can be read without Pillow; pip install 'floorwalker[floorplans]'"
        )
        raise FloorplanError.of(path, message) from None
    # We look at the size ourselves: Pillow warns of larger ones, or refuses them, without it.
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
