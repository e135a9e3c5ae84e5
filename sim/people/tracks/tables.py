"""Tracks in tables: CSV, Parquet, HDF5, columns of numbers, and JuPedSim's SQLite files.

The `trajectory.csv` of a recording is such a file.
"""

from __future__ import annotations

import json
import math
import re
import sqlite3
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import KW_ONLY
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from floorplan import InputError, Problem, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import LARGEST, SMALLEST, are_figures, figure
from floorplan.files.reading import LARGEST_RECORDED, read_lines, require_readable

Array = NDArray[np.float64]


class TrackError(InputError):
    """A file of tracks is invalid."""


def frame_rate(rate: float, path: Path, line: int | None = None) -> float:
    """Return a valid number of frames per second, or raise a `TrackError`."""
    if not SMALLEST <= rate <= LARGEST:
        message = f"the frame rate must be a number from {SMALLEST:g} to {LARGEST:g}"
        raise TrackError.of(path, message, line)
    return rate


@dataclass(frozen=True, eq=False, kw_only=True)
class Samples:
    """One body at N times: `t` in seconds or frames, `x` and `y` in a unit of length, each (N,).

    `rotation` is in radians, or None if the file has none. `rows` are the places of the samples in
    the file: lines, frames, or messages of a topic `place`.
    """

    rows: NDArray[np.int64]
    t: Array
    x: Array
    y: Array
    rotation: Array | None = None
    place: str = ""


@dataclass(frozen=True, eq=False)
class Tracks:
    """Bodies of a file, by name or number.

    If `t` counts frames, `frame_rate` is their number per second, or None if the file has none.
    `metre` is the unit of `x` and `y` in metres.
    """

    bodies: dict[str, Samples]
    _: KW_ONLY
    counts_frames: bool = False
    frame_rate: float | None = None
    metre: float = 1.0
    row: Literal["line", "row", "frame", "message"] = "line"


NAMES = {
    "t": ("t", "time"),
    "frame": ("frame", "fr"),
    "body": ("name", "body", "person", "id", "pedid"),
    "x": ("x", "posx"),
    "y": ("y", "posy"),
    "rotation": ("rotation", "heading"),
}
"""Names that a column may have, by its content."""

FIELDS = ("t", "x", "y", "rotation")

OBSMAT = {"frame": 0, "body": 1, "x": 2, "y": 4}
"""Columns of a row of 8 numbers, as in `obsmat.txt` of ETH: height and velocities are unused."""

METRE = {"m": 1.0, "cm": 0.01, "mm": 0.001}

MOST_PROBLEMS = 20
"""Maximum number of invalid rows before reading stops."""

MOST_ROWS = 20_000_000
"""Maximum number of rows of a Parquet or HDF5 file, whose few bytes can stand for many rows."""

_UNIT = r"(?i)\bx\s*(?:/|\[|\(|in)\s*(?:in\s+)?(m|cm|mm)\b"
_RATE = r"(?i)frame\s*rate\s*[:=]?\s*([0-9.]+)"


def read_text_tracks(path: Path) -> Tracks:
    """Return the tracks in the text file at `path`, or raise a `TrackError` with invalid rows."""
    rate: float | None = None
    metre = 1.0
    split: Callable[[str], list[str]] = str.split
    columns: dict[str, int] = {}
    has_header = True
    wanted: list[str] = []
    names: list[str] = []
    rows: list[int] = []
    figures: list[list[float]] = []
    problems: list[Problem] = []
    for number, line in enumerate(read_lines(path, TrackError), start=1):
        text = line.strip().removeprefix("\ufeff")
        if not text:
            continue
        if text.startswith("#"):
            if stated := re.search(_RATE, text):
                rate = frame_rate(figure(stated[1]), path, number)
            metre = METRE[stated[1].lower()] if (stated := re.search(_UNIT, text)) else metre
            continue
        if not columns:
            split = _splitting(text)
            columns, has_header = _columns(split(text), path, number)
            metre = METRE[stated[1].lower()] if (stated := re.search(_UNIT, text)) else metre
            wanted = _wanted(columns)
            if has_header:
                continue
        cells = split(text)
        if not (rows or problems) and len(cells) > columns["x"] and cells[columns["x"]] in METRE:
            metre = METRE[cells[columns["x"]]]  # a second line of the header, with units
            continue
        try:
            values = [_number(cells, columns[name], name) for name in wanted]
            names.append(cells[columns["body"]].strip())
        except UserError as why:
            problems.append(Problem(str(why), line=number))
            if len(problems) == MOST_PROBLEMS:
                break
            continue
        rows.append(number)
        figures.append(values)
    if not rows and not problems:
        problems.append(Problem("is empty: there are no rows"))
    if problems:
        raise TrackError(str(path), problems)
    table = np.array(figures)
    if not has_header:
        first = np.array([figure(name) for name in names])
        if columns is not OBSMAT and _begins_with_frames(first, table):
            first, table[:, 0] = table[:, 0].copy(), first
        names = [f"{body:.15g}" for body in first.tolist()]
    code_of = {name: code for code, name in enumerate(dict.fromkeys(names))}
    codes = np.array([code_of[name] for name in names])
    bodies = _bodies([*code_of], codes, table, np.array(rows))
    return Tracks(bodies, counts_frames="t" not in columns, frame_rate=rate, metre=metre)


def _begins_with_frames(first: Array, table: Array) -> bool:
    """Return whether the first column counts frames, and the first one of `table` has bodies.

    With the columns exchanged, a body would be at the places of all people in a frame.
    """
    frames, places = table[:, 0], table[:, 1:3]

    def roughness(bodies: Array, times: Array) -> float:
        # Mean length of steps and of their changes: people may walk in a regular row.
        order = np.lexsort((times, bodies))
        same = bodies[order][2:] == bodies[order][:-2]
        steps = np.diff(places[order], axis=0)
        changes = (steps[1:][same], np.diff(steps, axis=0)[same])
        return sum(float(np.hypot(*one.T).mean()) for one in changes) if same.any() else math.inf

    return roughness(frames, first) < roughness(first, frames)


def _bodies(
    names: Sequence[object], codes: NDArray[np.integer], figures: Array, rows: NDArray[np.int64]
) -> dict[str, Samples]:
    """Return samples by body: row k has the `figures` of the body called `names[codes[k]]`."""
    order = np.argsort(codes, kind="stable")
    ends = np.searchsorted(codes[order], np.arange(1, len(names)))
    bodies = {}
    for name, mine in zip(names, np.split(order, ends), strict=True):
        values = dict(zip(FIELDS, figures[mine].T, strict=False))
        bodies[f"{name}"] = Samples(rows=rows[mine], **values)
    return bodies


def read_parquet_tracks(path: Path) -> Tracks:
    """Return the tracks in the Parquet file at `path`, whose columns are named as in CSV.

    A `TrackError` names the problem, or the package to install.
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
            _require_rows(file.metadata.num_rows, path)
            table = file.read([names[column] for column in columns.values()])
        body = compute.dictionary_encode(table[names[columns["body"]]]).combine_chunks()
        wanted = [names[columns[name]] for name in _wanted(columns)]
        figures = np.column_stack([np.asarray(table[name], dtype=float) for name in wanted])
    except TrackError:
        raise
    except (ArrowException, OSError, TypeError, ValueError) as why:
        raise TrackError.of(path, f"is no Parquet file that can be read: {why}") from None
    _require_finite(figures, path)
    bodies = _bodies(
        body.dictionary.to_pylist(), np.asarray(body.indices), figures, _count(figures)
    )
    return Tracks(bodies, counts_frames="t" not in columns, row="row")


TRAJECTORY = "trajectory"
"""Name of the dataset in an HDF5 file of the Pedestrian Dynamics Data Archive."""


def read_hdf5_tracks(path: Path) -> Tracks:
    """Return the tracks in the HDF5 file at `path`, or raise a `TrackError`."""
    require_readable(path, TrackError, LARGEST_RECORDED)
    try:
        import h5py
    except ModuleNotFoundError:
        message = "h5py reads HDF5 and is missing: pip install 'floorwalker[tracks]'"
        raise TrackError.of(path, message) from None
    try:
        with h5py.File(path) as file:
            data = file[TRAJECTORY]
            names = data.dtype.names or ()
            columns, _ = _columns([*names], path, None)
            _require_rows(len(data), path)
            rate = data.attrs.get("fps")
            rate = None if rate is None else frame_rate(float(rate), path)
            table = data[:]
        ids, codes = np.unique(table[names[columns["body"]]], return_inverse=True)
        wanted = [names[columns[name]] for name in _wanted(columns)]
        figures = np.column_stack([table[name].astype(float) for name in wanted])
    except TrackError:
        raise
    except Exception as why:  # the library raises many errors for damaged files
        raise TrackError.of(path, f"is no HDF5 file with a table {TRAJECTORY!r}: {why}") from None
    _require_finite(figures, path)
    bodies = _bodies(ids.tolist(), codes, figures, _count(figures))
    return Tracks(bodies, counts_frames="t" not in columns, frame_rate=rate, row="row")


def _require_rows(count: int, path: Path) -> None:
    if not 0 < count <= MOST_ROWS:
        message = f"must have from 1 to {MOST_ROWS:,} rows, found {count:,}"
        raise TrackError.of(path, message)


def _require_finite(figures: Array, path: Path) -> None:
    if (unfit := np.flatnonzero(~are_figures(figures).all(axis=1))).size:
        raise TrackError.of(path, f"row {unfit[0]} has a figure that is not within ±{LARGEST:g}")


def _count(figures: Array) -> NDArray[np.int64]:
    return np.arange(len(figures))


def _wanted(columns: dict[str, int]) -> list[str]:
    """Return the names of the values of each sample, in the order of `Samples`."""
    time = "t" if "t" in columns else "frame"
    return [time, "x", "y", *(["rotation"] if "rotation" in columns else [])]


def _splitting(line: str) -> Callable[[str], list[str]]:
    """Return the function that splits the rows of a file with this first `line`."""
    for mark in (",", ";", "\t"):
        if mark in line:
            return lambda row: [cell.strip().strip('"') for cell in row.split(mark)]
    return str.split


def _columns(cells: list[str], path: Path, line: int | None) -> tuple[dict[str, int], bool]:
    """Return the column of each value, and whether the first row is a header."""
    if all(_is_number(cell) for cell in cells):
        if len(cells) < 4:
            message = f"expected a header, or the columns id, frame, x, y; found {len(cells)}"
            raise TrackError.of(path, message, line)
        return OBSMAT if len(cells) == 8 else {"body": 0, "frame": 1, "x": 2, "y": 3}, False
    plain = [re.split(r"[\s/\[(]", cell.strip().lower())[0] for cell in cells]
    columns = {
        name: plain.index(present[0])
        for name, words in NAMES.items()
        if (present := [word for word in words if word in plain])
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


_ROWS = "SELECT id, frame, pos_x, pos_y, ori_x, ori_y FROM trajectory_data ORDER BY id, frame"


def read_jupedsim_tracks(path: Path) -> Tracks:
    """Return the agents in the recording at `path`, or raise a `TrackError`.

    The name of an agent is that of the person, if the recording has it, otherwise its number. The
    agents of a person who was moved are one body with jumps.
    """
    require_readable(path, TrackError, LARGEST_RECORDED)
    try:
        with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)) as database:
            about = dict(database.execute("SELECT key, value FROM metadata"))
            rows = np.array(database.execute(_ROWS).fetchall(), dtype=float).reshape(-1, 6)
        rate = frame_rate(float(about["fps"]), path)
        people = _people(about.get("floorwalker_agents", "[]"))
    except TrackError:
        raise
    except (sqlite3.Error, LookupError, OverflowError, TypeError, ValueError) as why:
        raise TrackError.of(path, f"is no recording of JuPedSim: {why}") from None
    if not (fit := are_figures(rows).all(axis=1)).all():
        frame = rows[~fit][0, 1]
        raise TrackError.of(path, f"frame {frame:.0f} has a figure that is not within ±{LARGEST:g}")
    agents: dict[int, Array] = {
        int(agent): rows[rows[:, 0] == agent] for agent in np.unique(rows[:, 0])
    }
    bodies = {}
    for name, parts in people.items():
        there = [(begin, agents.pop(agent)) for begin, agent in parts if agent in agents]
        if there:
            bodies[name] = _samples_of_rows(np.concatenate(list(_joined(there, rate))))
    bodies |= {f"{agent}": _samples_of_rows(table) for agent, table in agents.items()}
    return Tracks(bodies, counts_frames=True, frame_rate=rate, row="frame")


def _people(text: str) -> dict[str, list[tuple[float, int]]]:
    """Return the agents of each person with the times of their begin (s), in order.

    A person who was moved is another agent from then on.
    """
    agents = defaultdict(list)
    for agent in json.loads(text):
        agents[str(agent["person"])].append((float(agent["begin"]), int(agent["id"])))
    return {name: sorted(parts) for name, parts in agents.items()}


def _joined(parts: Sequence[tuple[float, Array]], rate: float) -> Iterator[Array]:
    """Yield the rows of the agents of one person, with two at the time of each jump."""
    yield parts[0][1]
    for (_, before), (begin, after) in pairwise(parts):
        last, first = before[-1:].copy(), after[:1].copy()
        frame = begin * rate
        # An agent is assumed to be stationary between its last frame and the jump.
        last[0, 1] = first[0, 1] = frame if last[0, 1] <= frame <= first[0, 1] else first[0, 1]
        yield from (last, first, after)


def _samples_of_rows(table: Array) -> Samples:
    """Return rows of id, frame, x, y and heading (N, 6) as samples."""
    t, x, y, ori_x, ori_y = table.T[1:]
    return Samples(rows=t.astype(int), t=t, x=x, y=y, rotation=np.arctan2(ori_y, ori_x))
