"""A run in JuPedSim's format (SQLite, version 2), for PedPy and JuPedSim's own tools.

The agents are people. The walkable area is the floor without obstacles. A person who was teleported
is another agent afterwards, so that no speed, flow or crossing is invented. A person who enters or
leaves is an agent only in between. `floorwalker_agents` in `metadata` has the person of each agent.
"""

from __future__ import annotations

import json
import sqlite3
import zlib
from collections.abc import Iterator
from contextlib import closing
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path

import numpy as np
import shapely
from shapely.geometry import Point, Polygon

from floorplan.files.dataclass import dataclass

from ..record.outcome import Outcome
from ..record.sampling import Array, blocks_of_instants, sample

VERSION = 2
"""Version of JuPedSim's schema."""

_TABLES = """
    CREATE TABLE trajectory_data (frame INTEGER NOT NULL, id INTEGER NOT NULL,
        pos_x REAL NOT NULL, pos_y REAL NOT NULL, ori_x REAL NOT NULL, ori_y REAL NOT NULL);
    CREATE TABLE metadata (key TEXT NOT NULL UNIQUE PRIMARY KEY, value TEXT NOT NULL);
    CREATE TABLE geometry (hash INTEGER NOT NULL, wkt TEXT NOT NULL);
    CREATE UNIQUE INDEX geometry_hash ON geometry (hash);
    CREATE TABLE frame_data (frame INTEGER NOT NULL, geometry_hash INTEGER NOT NULL);
    CREATE INDEX frame_id_idx ON trajectory_data (frame, id);
"""


@dataclass(frozen=True)
class RecordedAgent:
    """A person between two teleports (times in seconds)."""

    id: int
    person: str
    begin: float
    end: float


def write(run: Outcome, path: Path, rate: float) -> None:
    """Write the people of `run` to `path` at `rate` frames a second."""
    with closing(sqlite3.connect(path)) as database:
        database.executescript(_TABLES)
        _write(run, database, rate)
        database.commit()


def _write(run: Outcome, database: sqlite3.Connection, rate: float) -> None:
    agents = list(_agents(run))
    area = _walkable(run)
    geometry = zlib.crc32(area.wkt.encode())
    west, south, east, north = area.bounds
    about = {
        "version": VERSION,
        "fps": float(rate),
        **{"xmin": west, "xmax": east, "ymin": south, "ymax": north},
        "floorwalker_agents": json.dumps([asdict(agent) for agent in agents]),
    }
    database.execute("INSERT INTO geometry VALUES (?, ?)", (geometry, area.wkt))
    database.executemany(
        "INSERT INTO metadata VALUES (?, ?)", [(key, str(value)) for key, value in about.items()]
    )
    first = 0
    for times in blocks_of_instants(run.duration, rate):
        frames = range(first, first + len(times))
        first += len(times)
        database.executemany(
            "INSERT INTO frame_data VALUES (?, ?)", ((frame, geometry) for frame in frames)
        )
        database.executemany(
            "INSERT INTO trajectory_data VALUES (?, ?, ?, ?, ?, ?)",
            _rows(run, agents, times, frames),
        )


def _agents(run: Outcome) -> Iterator[RecordedAgent]:
    number = 0
    for person in run.scene.people:
        for first, last in run.stays[person.name]:
            jumps = sorted(t for t in run.motions[person.name].jumps if first < t < last)
            for begin, end in pairwise([first, *jumps, last]):
                number += 1
                yield RecordedAgent(number, person.name, begin, end)


def _rows(
    run: Outcome, agents: list[RecordedAgent], times: Array, frames: range
) -> list[tuple[float, ...]]:
    """Return frame, id, x, y and heading as a unit vector, by frame and agent."""
    rows: list[tuple[float, ...]] = []
    for agent in agents:
        until = times < agent.end if agent.end < run.duration else times <= agent.end
        there = np.flatnonzero((times >= agent.begin) & until)
        table = sample(run.motions[agent.person], times[there])
        x, y, rotation = table[:, 0], table[:, 1], table[:, 2]
        figures = np.column_stack([x, y, np.cos(rotation), np.sin(rotation)]).tolist()
        rows += [
            (frames[k], agent.id, *line) for k, line in zip(there.tolist(), figures, strict=True)
        ]
    return sorted(rows)


def _walkable(run: Outcome) -> Polygon:
    """Return the walkable area. If there are several, the one with most initial positions."""
    human = run.floorplan.human
    starts = [Point(*run.scene.starts[person.name][:2]) for person in run.scene.people]

    def use(area: Polygon) -> tuple[int, float]:
        return sum(area.covers(start) for start in starts), area.area

    return max(shapely.get_parts(run.floorplan.free(0.0, human.height)), key=use)
