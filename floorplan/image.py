"""Grey images as arrays: PGM without further packages, anything else through Pillow."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .problems import FloorplanError, Problem

MOST_CELLS = 200_000_000
"""Images with more pixels are refused."""

_PGM_HEADER = re.compile(rb"(P[25])" + rb"(?:\s|#[^\n]*\n)+(\d{1,20})" * 3 + rb"(?:#[^\n]*\n)?\s")


@dataclass(frozen=True)
class GreyImage:
    """Brightness from 0 (black) to 1, (rows, columns), the top row first; and what is see-through.

    `top` is the number that stands for white in the file.
    """

    brightness: NDArray[np.floating[Any]]
    opaque: NDArray[np.bool_]
    top: int


def read_image(path: Path) -> GreyImage:
    """The grey image at `path`; `FloorplanError` says why it can't be used."""
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise FloorplanError(str(path), [Problem("there is no such image")]) from None
    except OSError as why:
        raise FloorplanError(str(path), [Problem(f"can't be read: {why.strerror}")]) from None
    except ValueError:
        raise FloorplanError(repr(str(path)), [Problem("is no name of a file")]) from None
    return _read_pgm(data, path) if data[:2] in (b"P2", b"P5") else _read_other(path)


def _read_pgm(data: bytes, path: Path) -> GreyImage:
    header = _PGM_HEADER.match(data)
    if header is None:
        raise FloorplanError(str(path), [Problem("is not a PGM image: its header is broken")])
    kind = header.group(1)
    width, height, top = (int(part) for part in header.groups()[1:])
    _check_size(width, height, path)
    if not 0 < top < 65536:
        raise FloorplanError(str(path), [Problem(f"is not a PGM image: its white is {top}")])
    body = data[header.end() :]
    values: NDArray[np.float64]
    if kind == b"P5":
        depth = np.dtype(">u2") if top > 255 else np.dtype("u1")
        values = np.frombuffer(body[: width * height * depth.itemsize], depth).astype(float)
    else:
        text = re.sub(rb"#[^\n]*", b"", body)
        try:
            values = np.array(text.split()[: width * height], dtype=float)
        except ValueError:
            message = "is not a PGM image: something in it is no number"
            raise FloorplanError(str(path), [Problem(message)]) from None
        if not ((values >= 0) & (values <= top)).all():
            message = f"is not a PGM image: a number in it is not from 0 to {top}"
            raise FloorplanError(str(path), [Problem(message)])
    if len(values) < width * height:
        message = f"is cut short: {len(values)} of {width * height} pixels"
        raise FloorplanError(str(path), [Problem(message)])
    brightness = (values / top).astype(np.float32).reshape(height, width)
    return GreyImage(brightness, np.ones(brightness.shape, bool), top)


def _read_other(path: Path) -> GreyImage:
    try:
        from PIL import Image, UnidentifiedImageError
    except ImportError:
        message = (
            "only PGM images can be read without Pillow; pip install 'floorwalker[floorplans]'"
        )
        raise FloorplanError(str(path), [Problem(message)]) from None
    # Our own limit is above the one at which Pillow suspects an attack.
    limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
    try:
        with Image.open(path) as image:
            _check_size(*image.size, path)
            sixteen = image.mode.startswith("I")
            pixels: NDArray[np.float32] = np.asarray(
                image if sixteen else image.convert("RGBA"), dtype=np.float32
            )
    except UnidentifiedImageError:
        raise FloorplanError(str(path), [Problem("is not an image")]) from None
    except (OSError, ValueError, SyntaxError) as why:
        raise FloorplanError(str(path), [Problem(f"can't be read: {why}")]) from None
    finally:
        Image.MAX_IMAGE_PIXELS = limit
    if sixteen:
        return GreyImage(pixels / 65535, np.ones(pixels.shape, bool), 65535)
    red, green, blue, alpha = (pixels[..., k] for k in range(4))
    if (red != green).any() or (red != blue).any():
        raise FloorplanError(str(path), [Problem("is in colour; a map is grey")])
    return GreyImage(red / 255, alpha == 255, 255)


def _check_size(width: int, height: int, path: Path) -> None:
    if width * height == 0:
        raise FloorplanError(str(path), [Problem("has no pixels")])
    if width * height > MOST_CELLS:
        message = f"has {width} × {height} pixels; at most {MOST_CELLS:,} can be read"
        raise FloorplanError(str(path), [Problem(message)])
