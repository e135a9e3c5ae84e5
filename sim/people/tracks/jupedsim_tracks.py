"""Tracks in a recording of JuPedSim (SQLite), of its own or one that Floorwalker exported."""

from __future__ import annotations

import json
import sqlite3
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import closing
from itertools import pairwise
from pathlib import Path

import numpy as np

from floorplan import LARGEST, LARGEST_RECORDED, are_figures, require_readable

from .samples import Array, Samples, TrackError, Tracks, frame_rate

_ROWS = "SELECT id, frame, pos_x, pos_y, ori_x, ori_y FROM trajectory_data ORDER BY id, frame"


def read_jupedsim_tracks(path: Path) -> Tracks:
    """Return the agents in the recording at `path`; `TrackError` says why it can't be read.

    An agent has the name of a person where the recording has it, and else its number. A person who
    was put elsewhere, and is several agents, is one body with jumps.
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
            bodies[name] = _samples(np.concatenate(list(_joined(there, rate))))
    bodies |= {f"{agent}": _samples(table) for agent, table in agents.items()}
    return Tracks(bodies, counts_frames=True, frame_rate=rate, row="frame")


def _people(text: str) -> dict[str, list[tuple[float, int]]]:
    """Return the agents that each person is, each from an instant (s) on, in order of time.

    A person is another agent whenever they were put elsewhere.
    """
    agents = defaultdict(list)
    for agent in json.loads(text):
        agents[str(agent["person"])].append((float(agent["begin"]), int(agent["id"])))
    return {name: sorted(parts) for name, parts in agents.items()}


def _joined(parts: Sequence[tuple[float, Array]], rate: float) -> Iterator[Array]:
    """Yield the rows of agents who are one person, with two at the instant of each jump."""
    yield parts[0][1]
    for (_, before), (begin, after) in pairwise(parts):
        last, first = before[-1:].copy(), after[:1].copy()
        frame = begin * rate
        # Between its last frame and the jump an agent stands, as far as anybody knows.
        last[0, 1] = first[0, 1] = frame if last[0, 1] <= frame <= first[0, 1] else first[0, 1]
        yield from (last, first, after)


def _samples(table: Array) -> Samples:
    """Return rows of id, frame, x, y and heading (N, 6) as samples."""
    t, x, y, ori_x, ori_y = table.T[1:]
    return Samples(t.astype(int), t, x, y, np.arctan2(ori_y, ori_x))
