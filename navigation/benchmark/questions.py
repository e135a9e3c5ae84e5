"""Questions of a benchmark: seeded ones, a user's own, and those of MovingAI scenarios."""

from __future__ import annotations

import csv
import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import shapely

from floorplan import (
    Floorplan,
    InputError,
    Point,
    Problem,
    UserError,
    figure,
    is_there,
    read_text,
    shown,
    suggestion,
)

from ..obstruction import blocked_place
from ..world import CollisionWorld
from .shortest import ShortestPaths

PER_SCENE = 10
"""Number of seeded questions before the AGVs move on."""

ENDS = ("x0", "y0", "x1", "y1")
"""Columns of a user's file: start and goal in metres. Each further one is named after an AGV."""

SCENARIO = ".scen"
"""Suffix of MovingAI's scenarios."""

_COLUMNS = 9
"""Of a scenario: bucket, map, its width and height, start and goal as cells, optimal length."""

_MARGIN = 1e-3
"""Metres. Seeded starts and goals have this much more room than they need."""

_MOST_DRAWS = 100_000


class QuestionsError(InputError):
    """A file of questions that can't be used."""


@dataclass(frozen=True)
class Scene:
    """A floor with its AGVs somewhere (lane positions in metres), and questions to ask there."""

    plan: Floorplan
    agvs: tuple[tuple[str, float], ...]
    questions: tuple[tuple[Point, Point], ...]
    shortest: tuple[float, ...]
    """Metres, for each question; infinite where no path leads from one end to the other.

    See `shortest.SHORTFALL` for how exact.
    """
    listed: tuple[float, ...] = ()
    """Metres that a scenario lists for each question; none for questions from elsewhere.

    They are those of the shortest paths over cells, with steps to the eight neighbours.
    """


@dataclass(frozen=True)
class Question:
    """A line of a file: places in metres, and AGVs at lane positions."""

    line: int
    start: Point
    goal: Point
    agvs: tuple[tuple[str, float], ...] = ()
    listed: float = math.nan


@dataclass
class _Found:
    """Questions of a file, and what is wrong with it, so far."""

    questions: list[Question] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)

    def wrong(self, message: str, line: int, place: str = "") -> None:
        self.problems.append(Problem(message, place, line))


def scenes(plan: Floorplan, *, queries: int, seed: int, radius: float) -> Iterator[Scene]:
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
        yield Scene(
            plan,
            tuple((lane.name, world.agv_position(lane.name)) for lane in plan.lanes),
            questions,
            tuple(paths.length(*question) for question in questions),
        )


def scenes_of(
    path: Path, plan: Floorplan, *, radius: float, queries: int | None = None, seed: int = 0
) -> list[Scene]:
    """Return the questions in the file at `path` about `plan`, for a disc of `radius` metres.

    With `queries`, so many of them, drawn by `seed`, in the order of the file. `QuestionsError`
    lists everything that is wrong with the file, also ends that leave the disc no room.
    """
    found = _Found()
    text = read_text(path, QuestionsError)
    if path.suffix.lower() == SCENARIO:
        _read_scenario(text, plan, found)
    else:
        _read_table(text, plan, found)
    if not found.problems and not found.questions:
        raise QuestionsError.of(path, "asks no question")
    world = CollisionWorld(plan)
    _check_room(found, world, radius)
    if found.problems:
        raise QuestionsError(str(path), sorted(found.problems, key=lambda p: p.line or 0))
    asked = found.questions
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


def _read_table(text: str, plan: Floorplan, found: _Found) -> None:
    rows = csv.reader(text.splitlines())
    header = [name.strip() for name in next(rows, [])]
    missing = [name for name in ENDS if name not in header]
    lanes = {lane.name: lane for lane in plan.lanes}
    unknown = [name for name in header if name not in (*ENDS, *lanes)]
    if missing:
        message = f"has no column {missing[0]}; the first line names x0, y0, x1, y1 and any AGVs"
        return found.wrong(message, 1)
    if unknown:
        known = suggestion(unknown[0], (*ENDS, *lanes))
        return found.wrong(f"{unknown[0]!r} is no column, nor an AGV of {plan.name}; {known}", 1)
    if len(set(header)) < len(header):
        return found.wrong("names a column twice", 1)
    for row in rows:
        number = rows.line_num
        if not any(cell.strip() for cell in row):
            continue
        if len(row) != len(header):
            found.wrong(f"has {len(row)} fields; the first line names {len(header)}", number)
            continue
        fields = dict(zip(header, (cell.strip() for cell in row), strict=True))
        ends = [_number(fields[name], number, name, found) for name in ENDS]
        agvs = []
        for name, lane in lanes.items():
            place = fields.get(name, "") or lane.start
            try:
                agvs.append((name, lane.lane_position(_figure(place, place))))
            except UserError as why:
                found.wrong(str(why), number, name)
        if None not in ends and len(agvs) == len(lanes):
            x0, y0, x1, y1 = (end for end in ends if end is not None)
            found.questions.append(Question(number, (x0, y0), (x1, y1), tuple(agvs)))
    return None


def _figure(text: str, otherwise: str) -> float | str:
    number = figure(text)
    return otherwise if math.isnan(number) else number


def _number(text: str, line: int, name: str, found: _Found) -> float | None:
    number = _figure(text, "")
    if isinstance(number, float):
        return number
    found.wrong(f"must be a finite number, found {shown(text)}", line, name)
    return None


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


def _read_scenario(text: str, plan: Floorplan, found: _Found) -> None:
    """Read cells as places on `plan`, which stands for the whole map: y points down in a map."""
    west, south, east, north = plan.boundary.bounds
    for number, words in _scenario_lines(text):
        if len(words) != _COLUMNS:
            found.wrong(_columns_fault(words), number)
            continue
        name = Path(words[1]).stem
        if name != plan.name:
            found.wrong(f"is about the map {words[1]}, not about the floor {plan.name}", number)
            continue
        figures = [_number(word, number, "", found) for word in words[2:]]
        if None in figures:
            continue
        width, height, x0, y0, x1, y1, optimal = (f for f in figures if f is not None)
        cell = (east - west) / width if width > 0 else 0.0
        if cell <= 0 or abs(cell * height - (north - south)) > 1e-6 * (north - south):
            shape = f"{words[2]} × {words[3]} cells"
            message = f"is about a map of {shape}, which {plan.name} is not: it is"
            found.wrong(f"{message} {east - west:g} × {north - south:g} m", number)
            continue
        outside = not (min(x0, x1) >= 0 and max(x0, x1) < width)
        if outside or not (min(y0, y1) >= 0 and max(y0, y1) < height):
            found.wrong(f"a cell is outside the map of {words[2]} × {words[3]}", number)
            continue
        start, goal = (
            (west + (x + 0.5) * cell, north - (y + 0.5) * cell) for x, y in ((x0, y0), (x1, y1))
        )
        found.questions.append(Question(number, start, goal, (), optimal * cell))


def _check_room(found: _Found, world: CollisionWorld, radius: float) -> None:
    for question in found.questions:
        _move(world, question.agvs)
        for end, at in (("start", question.start), ("goal", question.goal)):
            if not world.free(at, radius):
                found.wrong(blocked_place(world, at, end, radius), question.line)


def _scenes(asked: Iterable[Question], world: CollisionWorld, radius: float) -> Iterator[Scene]:
    paths: ShortestPaths | None = None
    for agvs, group in itertools.groupby(asked, key=lambda question: question.agvs):
        questions = list(group)
        _move(world, agvs)
        if paths is None or agvs:
            paths = ShortestPaths(world.walkable, radius)
        pairs = tuple((question.start, question.goal) for question in questions)
        yield Scene(
            world.plan,
            agvs,
            pairs,
            tuple(paths.length(*pair) for pair in pairs),
            tuple(question.listed for question in questions),
        )


def _move(world: CollisionWorld, agvs: Iterable[tuple[str, float]]) -> None:
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
        if not world.free(at, radius + _MARGIN):
            continue
        (within,) = np.nonzero(shapely.intersects_xy(pieces, *at))
        for other, piece in found:
            if piece in within:
                return other, at
        found += [(at, int(piece)) for piece in within]
    name = world.plan.name
    raise UserError(f"{name} has no two places for a radius of {radius:g} m with a path between")
