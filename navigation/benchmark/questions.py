"""Queries of a planner benchmark: seeded, from a CSV table, or from a MovingAI scenario."""

from __future__ import annotations

import csv
import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely

from floorplan import Floorplan, InputError, Lane, Point, Problem, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import figure
from floorplan.files.problems import shown, suggestion
from floorplan.files.reading import is_there, read_text

from ..obstruction import blocked_place
from ..world import CollisionWorld
from .shortest import ShortestPaths

PER_SCENE = 10
"""Number of seeded questions before the AGVs move."""

ENDS = ("x0", "y0", "x1", "y1")
"""Columns of a table: start and goal in metres. Further columns have the names of AGVs."""

SCENARIO = ".scen"
"""Suffix of MovingAI's scenarios."""

_COLUMNS = 9
"""Number of columns of a scenario."""

_SPARE_ROOM = 1e-3
"""Additional clearance of seeded starts and goals, in metres."""

_MOST_DRAWS = 100_000

Agvs = tuple[tuple[str, float], ...]
"""AGVs and their lane positions, in metres."""


class QuestionsError(InputError):
    """Problems of a file of questions."""


@dataclass(frozen=True, kw_only=True)
class Question:
    """Start and goal on a floor (metres), with its AGVs at fixed lane positions."""

    start: Point
    goal: Point
    agvs: Agvs = ()
    shortest: float = math.nan
    """Length of the shortest path (m): inf without a path, NaN if unknown. See `SHORTFALL`."""
    listed: float = math.nan
    """Length in a scenario in metres, otherwise NaN.

    It is that of the shortest path over cells, with steps to the eight neighbours.
    """


def drawn_questions(
    plan: Floorplan, *, queries: int, seed: int, radius: float
) -> Iterator[Question]:
    """Yield seeded questions on `plan` that have an answer, with AGVs anywhere on their lanes.

    Raise `UserError` if the floor has no room for two positions of a disc of `radius` metres.
    """
    rng = np.random.default_rng(seed)
    world = CollisionWorld(plan)
    paths: ShortestPaths | None = None
    for first in range(0, queries, PER_SCENE):
        agvs = tuple((lane.name, float(rng.uniform(*lane.limits))) for lane in plan.lanes)
        paths = _paths(world, agvs, radius, paths)
        ends = [_ends(world, paths, rng, radius) for _ in range(min(PER_SCENE, queries - first))]
        for start, goal in ends:
            length = paths.length(start, goal)
            yield Question(start=start, goal=goal, agvs=agvs, shortest=length)


def read_questions(
    path: Path, plan: Floorplan, *, radius: float, queries: int | None = None, seed: int = 0
) -> list[Question]:
    """Return the questions of the file at `path` about `plan`, for a disc of `radius` metres.

    `queries` limits their number. They are drawn by `seed`, in the order of the file.
    `QuestionsError` lists all faults of the file, including starts and goals that are not free.
    """
    reader = _QuestionsReader(plan)
    text = read_text(path, QuestionsError)
    if path.suffix.lower() == SCENARIO:
        reader.read_scenario(text)
    else:
        reader.read_table(text)
    if not reader.problems and not reader.questions:
        raise QuestionsError.of(path, "asks no question")
    world = CollisionWorld(plan)
    for line, question in reader.questions:
        _move(world, question.agvs)
        for end, at in (("start", question.start), ("goal", question.goal)):
            if not world.free(at, radius):
                reader.wrong(blocked_place(world, at, end, radius), line)
    if reader.problems:
        raise QuestionsError(str(path), sorted(reader.problems, key=lambda p: p.line or 0))
    questions = [question for _, question in reader.questions]
    if queries is not None and queries < len(questions):
        chosen = np.random.default_rng(seed).choice(len(questions), queries, replace=False)
        questions = [questions[k] for k in sorted(chosen.tolist())]
    return [*_with_lengths(questions, world, radius)]


def map_of(path: Path) -> Path:
    """Return the map that the scenario at `path` names, in the same folder.

    Raise `QuestionsError` if the first line names none, or if there is no such file.
    """
    for number, words in _scenario_lines(read_text(path, QuestionsError)):
        if fault := _columns_fault(words):
            raise QuestionsError.of(path, fault, line=number)
        map_path = path.parent / Path(words[1]).name
        if not is_there(map_path):
            message = f"is about {words[1]}, but there is no file {map_path}"
            raise QuestionsError.of(path, message, line=number)
        return map_path
    raise QuestionsError.of(path, "asks no question")


class _QuestionsReader:
    """Reader of questions about `plan`, which collects them and all faults of the file."""

    def __init__(self, plan: Floorplan) -> None:
        self.plan = plan
        self.questions: list[tuple[int, Question]] = []
        """Line and question."""
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
                question = Question(start=(x0, y0), goal=(x1, y1), agvs=tuple(agvs))
                self.questions.append((line, question))
        return None

    def _header_fault(self, header: Sequence[str]) -> str:
        columns = (*ENDS, *(lane.name for lane in self.plan.lanes))
        for name in ENDS:
            if name not in header:
                return f"has no column {name}; the first line names x0, y0, x1, y1 and any AGVs"
        for name in header:
            if name not in columns:
                hint = suggestion(name, columns)
                return f"{name!r} is no column, nor an AGV of {self.plan.name}; {hint}"
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
            if fault := _columns_fault(words):
                self.wrong(fault, line)
            elif Path(words[1]).stem != self.plan.name:
                name = self.plan.name
                self.wrong(f"is about the map {words[1]}, not about the floor {name}", line)
            else:
                values = [self._number(word, line) for word in words[2:]]
                if not any(map(math.isnan, values)):
                    self._add_cells(line, words, values)

    def _add_cells(self, line: int, words: Sequence[str], values: Sequence[float]) -> None:
        """Add cells as positions on `plan`, which is the whole map. y of cells points down."""
        width, height, x0, y0, x1, y1, optimal = values
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
            question = Question(start=start, goal=goal, listed=optimal * cell)
            self.questions.append((line, question))


def _scenario_lines(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the words of each line after the version. Names of maps may contain blanks."""
    for number, line in enumerate(text.split("\n"), start=1):
        if line.strip() and not (number == 1 and line.split()[0] == "version"):
            yield number, line.rstrip().split("\t") if "\t" in line else line.split()


def _columns_fault(words: Sequence[str]) -> str:
    if len(words) == _COLUMNS:
        return ""
    return (
        f"has {len(words)} columns; a scenario's are bucket, map, width, height,"
        " start x and y, goal x and y, optimal length"
    )


def _move(world: CollisionWorld, agvs: Agvs) -> None:
    for name, at in agvs:
        world.move_agv(name, at)


def _paths(
    world: CollisionWorld, agvs: Agvs, radius: float, before: ShortestPaths | None
) -> ShortestPaths:
    """Move the AGVs and return the shortest paths, or those `before` if there are no AGVs."""
    _move(world, agvs)
    return before if before and not agvs else ShortestPaths(world.walkable, radius)


def _with_lengths(
    questions: Iterable[Question], world: CollisionWorld, radius: float
) -> Iterator[Question]:
    """Yield the questions with the lengths of their shortest paths."""
    paths: ShortestPaths | None = None
    for agvs, group in itertools.groupby(questions, key=lambda question: question.agvs):
        paths = _paths(world, agvs, radius, paths)
        for question in group:
            yield replace(question, shortest=paths.length(question.start, question.goal))


def _ends(
    world: CollisionWorld, paths: ShortestPaths, rng: np.random.Generator, radius: float
) -> tuple[Point, Point]:
    """Return two positions with room for the disc and a path between them."""
    low_x, low_y, high_x, high_y = world.plan.boundary.bounds
    pieces = [piece for piece in shapely.get_parts(paths.room) if piece.area > 0]
    drawn: list[tuple[Point, int]] = []
    for _ in range(_MOST_DRAWS):
        at = (float(rng.uniform(low_x, high_x)), float(rng.uniform(low_y, high_y)))
        if not world.free(at, radius + _SPARE_ROOM):
            continue
        (within,) = np.nonzero(shapely.intersects_xy(pieces, *at))
        for other, piece in drawn:
            if piece in within:
                return other, at
        drawn += [(at, int(piece)) for piece in within]
    name = world.plan.name
    raise UserError(f"{name} has no two places for a radius of {radius:g} m with a path between")
