"""Queries of a planner benchmark (seeded, CSV, MovingAI scenarios) and their shortest lengths.

Every corner of what is left of the floor when all edges are grown by the radius is linked with
every other that it sees, and shortest paths are searched over these links (Dijkstra). Grown
corners are drawn from inside, so lengths are never too long, and too short by no more than
`SHORTFALL` of their arcs.
"""

from __future__ import annotations

import csv
import heapq
import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from floorplan import Floorplan, InputError, Point, Problem, UserError
from floorplan.files.fields import figure
from floorplan.files.problems import shown, suggestion
from floorplan.files.reading import is_there, read_text

from ..planner import blocked_place
from ..world import CollisionWorld

SIDES = 64
"""The sides of the polygons that stand for discs."""

SHORTFALL = 1 - math.cos(math.pi / SIDES)
"""Share by which arcs may come out too short: 0.12 %."""

_MARGIN = 1e-3
"""Metres. Gaps that are no more than this wider than the disc count as closed."""

_EDGE = 1e-7
"""Metres. How far links may leave the room, so that rounding doesn't cut those along its edges."""

_ROWS = 512

MOST_CORNERS = 20_000
"""Linking as many takes about a minute; on floors with more, nobody knows the shortest paths."""

Floats = NDArray[np.float64]
Links = list[list[tuple[int, float]]]


class ShortestPaths:
    """Lengths of shortest paths for a disc of `radius` metres within `walkable`."""

    def __init__(self, walkable: shapely.Geometry, radius: float) -> None:
        self.room = _shrunk(walkable, radius)
        """Free space of the centre of the disc."""
        self._wide = self.room.buffer(_EDGE)
        shapely.prepare(self._wide)
        shapely.prepare(self.room)
        self._corner, self._before, self._after = _corners(self.room)
        known = len(self._corner) <= MOST_CORNERS
        self._links = self._between_corners() if known else None

    def length(self, start: Point, goal: Point) -> float:
        """Return the metres from `start` to `goal`; infinity where there is no path.

        NaN where that would take too long to find out.
        """
        ends = np.array([start, goal])
        if self._see(ends[:1], ends[1:])[0]:
            return math.dist(start, goal)
        if self._links is None:
            return math.nan
        from_start, to_goal = (dict(self._from(end)) for end in ends)
        best = dict(from_start)
        queue = [(far, k) for k, far in from_start.items()]
        heapq.heapify(queue)
        shortest = math.inf
        while queue:
            far, here = heapq.heappop(queue)
            # Dijkstra: what comes from now on is no shorter than what is known to lead to the goal.
            if far >= shortest:
                break
            if far > best[here]:
                continue
            shortest = min(shortest, far + to_goal.get(here, math.inf))
            for there, step in self._links[here]:
                if far + step < best.get(there, math.inf):
                    best[there] = far + step
                    heapq.heappush(queue, (far + step, there))
        return shortest

    def _from(self, end: Floats) -> list[tuple[int, float]]:
        away = self._corner - end
        (touched,) = np.nonzero(_taut(away, self._before, self._after))
        seen = self._see(np.broadcast_to(end, (len(touched), 2)), self._corner[touched])
        return [(int(k), math.hypot(*away[k])) for k in touched[seen]]

    def _see(self, a: Floats, b: Floats) -> NDArray[np.bool_]:
        inside: NDArray[np.bool_] = shapely.covers(
            self._wide, shapely.linestrings(np.stack([a, b], axis=1))
        )
        return inside

    def _between_corners(self) -> Links:
        links: Links = [[] for _ in self._corner]
        for first in range(0, len(links), _ROWS):
            rows = slice(first, first + _ROWS)
            away = self._corner[None] - self._corner[rows, None]
            here = _taut(away, self._before[rows, None], self._after[rows, None])
            one, other = np.nonzero(here & _taut(away, self._before, self._after))
            one += first
            one, other = one[one < other], other[one < other]
            seen = self._see(self._corner[one], self._corner[other])
            for i, j in zip(one[seen].tolist(), other[seen].tolist(), strict=True):
                far = math.dist(self._corner[i], self._corner[j])
                links[i].append((j, far))
                links[j].append((i, far))
        return links


def _shrunk(walkable: shapely.Geometry, radius: float) -> shapely.Geometry:
    """Return `walkable` without discs at its corners, strips along its edges, and tight gaps."""
    angles = np.linspace(0, 2 * math.pi, SIDES, endpoint=False)
    disc = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    grown = []
    for line in shapely.get_parts(walkable.boundary):
        points = shapely.get_coordinates(line)
        grown += list(shapely.polygons(points[:-1, None] + disc))
        for a, b in itertools.pairwise(points):
            across = np.array([a[1] - b[1], b[0] - a[0]]) * radius / math.dist(a, b)
            grown.append(shapely.Polygon([a + across, b + across, b - across, a - across]))
    tight = _tight_gaps(walkable, radius)
    return walkable.difference(shapely.union_all([*grown, *tight]))


def _tight_gaps(walkable: shapely.Geometry, radius: float) -> list[shapely.Geometry]:
    """Return the middles of the gaps through which a disc comes only by a hair, or not at all.

    What is lost when the room is shrunk by the margin and grown back is too narrow for it.
    """
    wide = walkable.buffer(-radius - _MARGIN / 2, quad_segs=SIDES).buffer(_MARGIN)
    lost = walkable.buffer(-radius, quad_segs=SIDES).difference(wide)
    return [piece.buffer(_MARGIN) for piece in shapely.get_parts(lost) if not piece.is_empty]


def _corners(room: shapely.Geometry) -> tuple[Floats, Floats, Floats]:
    """The corners that stick out into `room`, and the vectors to the corners on either side."""
    found = []
    for polygon in shapely.get_parts(shapely.orient_polygons(room)):
        for ring in (polygon.exterior, *polygon.interiors):
            points = shapely.get_coordinates(ring)[:-1]
            before, after = np.roll(points, 1, 0) - points, np.roll(points, -1, 0) - points
            out = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] > 0
            found.append(np.stack([points[out], before[out], after[out]]))
    corner, before, after = np.concatenate([np.empty((3, 0, 2)), *found], axis=1)
    return corner, before, after


def _taut(along: Floats, before: Floats, after: Floats) -> NDArray[np.bool_]:
    """Return whether a line along `along` leaves both sides of a corner on one side of it."""
    # A shortest path is a taut string: it bends at corners that stick out only, and comes and goes
    # along lines that touch them there. All other links can be left out: the tangent graph of
    # Y.-H. Liu and S. Arimoto, International Journal of Robotics Research 11, 1992.
    one = along[..., 0] * before[..., 1] - along[..., 1] * before[..., 0]
    other = along[..., 0] * after[..., 1] - along[..., 1] * after[..., 0]
    slack = 1e-9 * (1 + np.abs(along).sum(axis=-1))
    taut: NDArray[np.bool_] = (one * other >= 0) | (np.abs(one) < slack) | (np.abs(other) < slack)
    return taut


PER_SCENE = 10
"""Number of seeded questions before the AGVs move on."""

ENDS = ("x0", "y0", "x1", "y1")
"""Columns of a user's file: start and goal in metres. Each further one is named after an AGV."""

SCENARIO = ".scen"
"""Suffix of MovingAI's scenarios."""

_COLUMNS = 9
"""Of a scenario: bucket, map, its width and height, start and goal as cells, optimal length."""

_SPARE_ROOM = 1e-3
"""Metres. Seeded starts and goals have this much more room than they need."""

_MOST_DRAWS = 100_000


class QuestionsError(InputError):
    """A file of questions that can't be used."""


@dataclass(frozen=True)
class QuerySet:
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
class Query:
    """A line of a file: places in metres, and AGVs at lane positions."""

    line: int
    start: Point
    goal: Point
    agvs: tuple[tuple[str, float], ...] = ()
    listed: float = math.nan


@dataclass
class _Found:
    """Questions of a file, and what is wrong with it, so far."""

    questions: list[Query] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)

    def wrong(self, message: str, line: int, place: str = "") -> None:
        self.problems.append(Problem(message, place, line))


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
            plan,
            tuple((lane.name, world.agv_position(lane.name)) for lane in plan.lanes),
            questions,
            tuple(paths.length(*question) for question in questions),
        )


def scenes_of(
    path: Path, plan: Floorplan, *, radius: float, queries: int | None = None, seed: int = 0
) -> list[QuerySet]:
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
            found.questions.append(Query(number, (x0, y0), (x1, y1), tuple(agvs)))
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
        found.questions.append(Query(number, start, goal, (), optimal * cell))


def _check_room(found: _Found, world: CollisionWorld, radius: float) -> None:
    for question in found.questions:
        _move(world, question.agvs)
        for end, at in (("start", question.start), ("goal", question.goal)):
            if not world.free(at, radius):
                found.wrong(blocked_place(world, at, end, radius), question.line)


def _scenes(asked: Iterable[Query], world: CollisionWorld, radius: float) -> Iterator[QuerySet]:
    paths: ShortestPaths | None = None
    for agvs, group in itertools.groupby(asked, key=lambda question: question.agvs):
        questions = list(group)
        _move(world, agvs)
        if paths is None or agvs:
            paths = ShortestPaths(world.walkable, radius)
        pairs = tuple((question.start, question.goal) for question in questions)
        yield QuerySet(
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
        if not world.free(at, radius + _SPARE_ROOM):
            continue
        (within,) = np.nonzero(shapely.intersects_xy(pieces, *at))
        for other, piece in found:
            if piece in within:
                return other, at
        found += [(at, int(piece)) for piece in within]
    name = world.plan.name
    raise UserError(f"{name} has no two places for a radius of {radius:g} m with a path between")
