"""Tracks in tables: CSV or Parquet, or columns id, frame, x, y as PedPy and PeTrack have them.

A recording's own `trajectory.csv` is such a file.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from floorplan import LARGEST_RECORDED, Problem, UserError, figure, read_lines, require_readable

from .samples import Samples, TrackError, Tracks, frame_rate

NAMES = {
    "t": ("t", "time"),
    "frame": ("frame", "fr"),
    "body": ("name", "body", "person", "id"),
    "x": ("x",),
    "y": ("y",),
    "rotation": ("rotation", "heading"),
}
"""Names that a column may have, by what is in it."""

METRE = {"m": 1.0, "cm": 0.01, "mm": 0.001}

MOST_PROBLEMS = 20
"""Reading stops after so many rows that can't be read."""

MOST_ROWS = 20_000_000
"""Rows of a Parquet file, at most: few bytes can stand for many of them."""

_UNIT = r"(?i)\bx\s*(?:/|\[|\(|in)\s*(?:in\s+)?(m|cm|mm)\b"
_RATE = r"(?i)frame\s*rate\s*[:=]?\s*([0-9.]+)"


@dataclass
class _Track:
    rows: list[int] = field(default_factory=list)
    figures: list[list[float]] = field(default_factory=list)


def read_text_tracks(path: Path) -> Tracks:
    """Return the tracks in the text file at `path`; `TrackError` with the rows that are unfit."""
    rate: float | None = None
    metre = 1.0
    split: Callable[[str], list[str]] = str.split
    columns: dict[str, int] = {}
    wanted: list[str] = []
    found: dict[str, _Track] = {}
    problems: list[Problem] = []
    for number, line in enumerate(read_lines(path, TrackError), start=1):
        text = line.strip().removeprefix("\ufeff")
        if not text:
            continue
        if text.startswith("#"):
            if told := re.search(_RATE, text):
                rate = frame_rate(figure(told[1]), path, number)
            metre = METRE[told[1].lower()] if (told := re.search(_UNIT, text)) else metre
            continue
        if not columns:
            split = _splitting(text)
            columns, is_header = _columns(split(text), path, number)
            metre = METRE[told[1].lower()] if (told := re.search(_UNIT, text)) else metre
            wanted = _wanted(columns)
            if is_header:
                continue
        cells = split(text)
        try:
            figures = [_number(cells, columns[name], name) for name in wanted]
            body = cells[columns["body"]].strip()
        except UserError as why:
            problems.append(Problem(str(why), line=number))
            if len(problems) == MOST_PROBLEMS:
                break
            continue
        track = found.get(body)
        if track is None:
            track = found[body] = _Track()
        track.rows.append(number)
        track.figures.append(figures)
    if not columns:
        problems.append(Problem("is empty: there are no rows"))
    if problems:
        raise TrackError(str(path), problems)
    bodies = {name: _samples(track, metre) for name, track in found.items()}
    return Tracks(bodies, counts_frames="t" not in columns, frame_rate=rate)


def read_parquet_tracks(path: Path) -> Tracks:
    """Return the tracks in the Parquet file at `path`, whose columns are named as in CSV.

    `TrackError` says what is wrong with it, or what to install.
    """
    require_readable(path, TrackError, LARGEST_RECORDED)
    try:
        from pyarrow import ArrowException, compute
        from pyarrow.parquet import ParquetFile
    except ModuleNotFoundError:
        message = "pyarrow reads Parquet and is missing: pip install 'floorwalker[export]'"
        raise TrackError.of(path, message) from None
    try:
        with ParquetFile(path) as file:
            names = file.schema_arrow.names
            columns, _ = _columns(names, path, None)
            if file.metadata.num_rows > MOST_ROWS:
                message = f"has more than {MOST_ROWS:,} rows: {file.metadata.num_rows:,}"
                raise TrackError.of(path, message)
            table = file.read([names[column] for column in columns.values()])
        body = compute.dictionary_encode(table[names[columns["body"]]]).combine_chunks()
        wanted = [names[columns[name]] for name in _wanted(columns)]
        figures = np.column_stack([np.asarray(table[name], dtype=float) for name in wanted])
    except TrackError:
        raise
    except (ArrowException, OSError, TypeError, ValueError) as why:
        raise TrackError.of(path, f"is no Parquet file that can be read: {why}") from None
    if (unfit := np.flatnonzero(~np.isfinite(figures).all(axis=1))).size:
        raise TrackError.of(path, f"row {unfit[0]} has a figure that is not finite")
    codes = np.asarray(body.indices)
    bodies = {}
    for code, name in enumerate(body.dictionary.to_pylist()):
        rows = np.flatnonzero(codes == code)
        bodies[f"{name}"] = Samples(rows, *figures[rows].T)
    return Tracks(bodies, counts_frames="t" not in columns, row="row")


def _wanted(columns: dict[str, int]) -> list[str]:
    """Return what is read of each sample, in the order of `Samples`."""
    time = "t" if "t" in columns else "frame"
    return [time, "x", "y", *(["rotation"] if "rotation" in columns else [])]


def _samples(track: _Track, metre: float) -> Samples:
    t, x, y, *rotation = np.array(track.figures).T
    turned = rotation[0] if rotation else None
    return Samples(np.array(track.rows), t, x * metre, y * metre, turned)


def _splitting(line: str) -> Callable[[str], list[str]]:
    """Return how the rows of a file that begin with `line` are split."""
    for mark in (",", ";", "\t"):
        if mark in line:
            return lambda row: [cell.strip().strip('"') for cell in row.split(mark)]
    return str.split


def _columns(cells: list[str], path: Path, line: int | None) -> tuple[dict[str, int], bool]:
    """Return where in a row everything stands, and whether the first row is a header."""
    if all(_is_number(cell) for cell in cells):
        if len(cells) < 4:
            message = f"expected a header, or the columns id, frame, x, y; found {len(cells)}"
            raise TrackError.of(path, message, line)
        return {"body": 0, "frame": 1, "x": 2, "y": 3}, False
    plain = [re.split(r"[\s/\[(]", cell.strip().lower())[0] for cell in cells]
    columns = {
        name: plain.index(known[0])
        for name, words in NAMES.items()
        if (known := [word for word in words if word in plain])
    }
    missing = [name for name in ("x", "y") if name not in columns]
    if "body" not in columns:
        missing.append("name (or body, id)")
    if not {"t", "frame"} & {*columns}:
        missing.append("t (or frame)")
    if missing:
        message = f"the header has no column {', '.join(missing)}; found {', '.join(cells)}"
        raise TrackError.of(path, message, line)
    return columns, True


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _number(cells: list[str], column: int, name: str) -> float:
    if column >= len(cells):
        raise UserError(f"has {len(cells)} columns, and none for {name}")
    value = figure(cells[column])
    if math.isnan(value):
        raise UserError(f"{name} must be a number, found {cells[column][:40]!r}")
    return value
