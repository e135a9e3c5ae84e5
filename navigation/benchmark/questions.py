"""Queries of a planner benchmark: seeded, from a CSV table, or from a MovingAI scenario."""

from __future__ import annotations

import csv
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely

from floorplan import Floorplan, InputError, Lane, Point, Problem, UserError
from floorplan.files.fields import figure
from floorplan.files.problems import shown, suggestion
from floorplan.files.reading import is_there, read_text

from ..planner import blocked_place
from ..world import CollisionWorld
from .shortest import ShortestPaths

PER_SCENE = 10
"""Number of seeded questions before the AGVs move on."""

ENDS = ("x0", "y0", "x1", "y1")
"""Columns of a table: start and goal in metres. Each further one is named after an AGV."""

SCENARIO = ".scen"
"""Suffix of MovingAI's scenarios."""

_COLUMNS = 9
"""Of a scenario: bucket, map, its width and height, start and goal as cells, optimal length."""

_SPARE_ROOM = 1e-3
"""Metres. Seeded starts and goals have this much more room than they need."""

_MOST_DRAWS = 100_000

Agvs = tuple[tuple[str, float], ...]
"""AGVs and their lane positions, in metres."""


class QuestionsError(InputError):
    """A file of questions that cannot be used."""


@dataclass(frozen=True, kw_only=True)
class QuerySet:
    """A floor with its AGVs somewhere (lane positions in metres), and questions to ask there."""

    plan: Floorplan
    agvs: Agvs
    questions: tuple[tuple[Point, Point], ...]
    shortest: tuple[float, ...]
    """Metres, for each question: inf without a path, NaN if unknown. See `SHORTFALL`."""
    listed: tuple[float, ...]
    """Metres that a scenario lists for each question; NaN for questions from elsewhere.

    They are those of the shortest paths over cells, with steps to the eight neighbours.
    """


@dataclass(frozen=True)
class _Query:
    """A line of a file: places in metres, and AGVs at lane positions."""

    line: int
    ends: tuple[Point, Point]
    agvs: Agvs = ()
    listed: float = math.nan


def scenes(plan: Floorplan, *, queries: int, seed: int, radius: float) -> Iterator[QuerySet]:
    """Yield seeded questions on `plan` that have an answer, with AGVs anywhere on their lanes.

    `ValueError` if there is no room on the floor for two places.
    """
    rng = np.random.default_rng(seed)
    world = CollisionWorld(plan)
    paths: ShortestPaths | None = None
    for first in range(0, queries, PER_SCENE):
        for lane in plan.lanes:
            world.move_agv(lane.name, float(rng.uniform(*lane.limits)))
        if paths is None or plan.lanes:
            paths = ShortestPaths(world.walkable, radius)
        count = min(PER_SCENE, queries - first)
        questions = tuple(_drawn(world, paths, rng, radius) for _ in range(count))
        yield QuerySet(
            plan=plan,
            agvs=tuple((lane.name, world.agv_position(lane.name)) for lane in plan.lanes),
            questions=questions,
            shortest=tuple(paths.length(*question) for question in questions),
            listed=(math.nan,) * count,
        )


def scenes_of(
    path: Path, plan: Floorplan, *, radius: float, queries: int | None = None, seed: int = 0
) -> list[QuerySet]:
    """Return the questions in the file at `path` about `plan`, for a disc of `radius` metres.

    With `queries`, so many of them, drawn by `seed`, in the order of the file. `QuestionsError`
    lists everything that is wrong with the file, also ends that leave the disc no room.
    """
    reader = _QuestionsReader(plan)
    text = read_text(path, QuestionsError)
    if path.suffix.lower() == SCENARIO:
        reader.read_scenario(text)
    else:
        reader.read_table(text)
    asked = reader.queries
    if not reader.problems and not asked:
        raise QuestionsError.of(path, "asks no question")
    world = CollisionWorld(plan)
    for query in asked:
        _move(world, query.agvs)
        for end, at in zip(("start", "goal"), query.ends, strict=True):
            if not world.free(at, radius):
                reader.wrong(blocked_place(world, at, end, radius), query.line)
    if reader.problems:
        raise QuestionsError(str(path), sorted(reader.problems, key=lambda p: p.line or 0))
    if queries is not None and queries < len(asked):
        chosen = np.random.default_rng(seed).choice(len(asked), queries, replace=False)
        asked = [asked[k] for k in sorted(chosen.tolist())]
    return list(_scenes(asked, world, radius))


def map_of(path: Path) -> Path:
    """Return the map that the scenario at `path` is about, which lies beside it.

    `QuestionsError` if its first line names none, or there is no such file.
    """
    for number, words in _scenario_lines(read_text(path, QuestionsError)):
        if len(words) != _COLUMNS:
            raise QuestionsError.of(path, _columns_fault(words), line=number)
        map_path = path.parent / Path(words[1]).name
        if not is_there(map_path):
            message = f"is about {words[1]}, but there is no file {map_path}"
            raise QuestionsError.of(path, message, line=number)
        return map_path
    raise QuestionsError.of(path, "asks no question")


class _QuestionsReader:
    """Reader of questions about `plan`, which collects them and what is wrong with the file."""

    def __init__(self, plan: Floorplan) -> None:
        self.plan = plan
        self.queries: list[_Query] = []
        self.problems: list[Problem] = []

    def wrong(self, message: str, line: int, place: str = "") -> None:
        """Add a problem."""
        self.problems.append(Problem(message, place, line))

    def read_table(self, text: str) -> None:
        """Read a CSV table whose first line names the columns."""
        rows = csv.reader(text.splitlines())
        header = [name.strip() for name in next(rows, [])]
        if fault := self._header_fault(header):
            return self.wrong(fault, 1)
        for row in rows:
            line, cells = rows.line_num, [cell.strip() for cell in row]
            if not any(cells):
                continue
            if len(row) != len(header):
                self.wrong(f"has {len(row)} fields; the first line names {len(header)}", line)
                continue
            fields, before = dict(zip(header, cells, strict=True)), len(self.problems)
            x0, y0, x1, y1 = (self._number(fields[name], line, name) for name in ENDS)
            agvs = [
                (lane.name, self._lane_position(lane, fields.get(lane.name, ""), line))
                for lane in self.plan.lanes
            ]
            if len(self.problems) == before:
                self.queries.append(_Query(line, ((x0, y0), (x1, y1)), tuple(agvs)))
        return None

    def _header_fault(self, header: Sequence[str]) -> str:
        columns = (*ENDS, *(lane.name for lane in self.plan.lanes))
        for name in ENDS:
            if name not in header:
                return f"has no column {name}; the first line names x0, y0, x1, y1 and any AGVs"
        for name in header:
            if name not in columns:
                known = suggestion(name, columns)
                return f"{name!r} is no column, nor an AGV of {self.plan.name}; {known}"
        return "names a column twice" if len(set(header)) < len(header) else ""

    def _number(self, text: str, line: int, name: str = "") -> float:
        number = figure(text)
        if math.isnan(number):
            self.wrong(f"must be a finite number, found {shown(text)}", line, name)
        return number

    def _lane_position(self, lane: Lane, text: str, line: int) -> float:
        place = text or lane.start
        number = figure(place)
        try:
            return lane.lane_position(place if math.isnan(number) else number)
        except UserError as why:
            self.wrong(str(why), line, lane.name)
            return math.nan

    def read_scenario(self, text: str) -> None:
        """Read a MovingAI scenario."""
        for line, words in _scenario_lines(text):
            if len(words) != _COLUMNS:
                self.wrong(_columns_fault(words), line)
            elif Path(words[1]).stem != self.plan.name:
                name = self.plan.name
                self.wrong(f"is about the map {words[1]}, not about the floor {name}", line)
            else:
                before = len(self.problems)
                values = [self._number(word, line) for word in words[2:]]
                if len(self.problems) == before:
                    self._add_cells(line, words, *values)

    def _add_cells(
        self,
        line: int,
        words: Sequence[str],
        width: float,
        height: float,
        x0: float,
        y0: float,
        x1: float,
        y1: float,
        optimal: float,
    ) -> None:
        """Add cells as places on `plan`, which stands for the whole map: y points down there."""
        west, south, east, north = self.plan.boundary.bounds
        cell = (east - west) / width if width > 0 else 0.0
        if cell <= 0 or abs(cell * height - (north - south)) > 1e-6 * (north - south):
            message = f"is about a map of {words[2]} × {words[3]} cells, which {self.plan.name} is"
            self.wrong(f"{message} not: it is {east - west:g} × {north - south:g} m", line)
        elif not all(0 <= x < width and 0 <= y < height for x, y in ((x0, y0), (x1, y1))):
            self.wrong(f"a cell is outside the map of {words[2]} × {words[3]}", line)
        else:
            start, goal = (
                (west + (x + 0.5) * cell, north - (y + 0.5) * cell) for x, y in ((x0, y0), (x1, y1))
            )
            self.queries.append(_Query(line, (start, goal), (), optimal * cell))


def _scenario_lines(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the lines after the version, each in words; the names of maps may have blanks."""
    for number, line in enumerate(text.split("\n"), start=1):
        if line.strip() and not (number == 1 and line.split()[0] == "version"):
            yield number, line.rstrip().split("\t") if "\t" in line else line.split()


def _columns_fault(words: Sequence[str]) -> str:
    return (
        f"has {len(words)} columns; a scenario's are bucket, map, width, height,"
        " start x and y, goal x and y, optimal length"
    )


def _scenes(asked: list[_Query], world: CollisionWorld, radius: float) -> Iterator[QuerySet]:
    paths: ShortestPaths | None = None
    for agvs, group in itertools.groupby(asked, key=lambda query: query.agvs):
        queries = list(group)
        _move(world, agvs)
        if paths is None or agvs:
            paths = ShortestPaths(world.walkable, radius)
        yield QuerySet(
            plan=world.plan,
            agvs=agvs,
            questions=tuple(query.ends for query in queries),
            shortest=tuple(paths.length(*query.ends) for query in queries),
            listed=tuple(query.listed for query in queries),
        )


def _move(world: CollisionWorld, agvs: Agvs) -> None:
    for name, at in agvs:
        world.move_agv(name, at)


def _drawn(
    world: CollisionWorld, paths: ShortestPaths, rng: np.random.Generator, radius: float
) -> tuple[Point, Point]:
    """Return two places with room to stand and a path between them."""
    low_x, low_y, high_x, high_y = world.plan.boundary.bounds
    pieces = [piece for piece in shapely.get_parts(paths.room) if piece.area > 0]
    found: list[tuple[Point, int]] = []
    for _ in range(_MOST_DRAWS):
        at = (float(rng.uniform(low_x, high_x)), float(rng.uniform(low_y, high_y)))
        if not world.free(at, radius + _SPARE_ROOM):
            continue
        (within,) = np.nonzero(shapely.intersects_xy(pieces, *at))
        for other, piece in found:
            if piece in within:
                return other, at
        found += [(at, int(piece)) for piece in within]
    name = world.plan.name
    raise UserError(f"{name} has no two places for a radius of {radius:g} m with a path between")
