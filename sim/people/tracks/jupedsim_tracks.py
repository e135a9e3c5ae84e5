"""Tracks in a recording of JuPedSim (SQLite), of its own or one that Floorwalker exported."""

from __future__ import annotations

import json
import sqlite3
from collections import defaultdict
from contextlib import closing
from pathlib import Path

import numpy as np

from floorplan import LARGEST, LARGEST_RECORDED, are_figures, require_readable

from .samples import Samples, TrackError, Tracks, frame_rate

_ROWS = "SELECT id, frame, pos_x, pos_y, ori_x, ori_y FROM trajectory_data ORDER BY id, frame"


def read_jupedsim_tracks(path: Path) -> Tracks:
    """Return the agents in the recording at `path`; `TrackError` says why it can't be read.

    An agent has the name of a person where the recording has it, and else its number.
    """
    require_readable(path, TrackError, LARGEST_RECORDED)
    try:
        with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)) as database:
            about = dict(database.execute("SELECT key, value FROM metadata"))
            rows = np.array(database.execute(_ROWS).fetchall(), dtype=float).reshape(-1, 6)
        rate = frame_rate(float(about["fps"]), path)
        names = _names(about.get("floorwalker_agents", "[]"))
    except TrackError:
        raise
    except (sqlite3.Error, LookupError, OverflowError, TypeError, ValueError) as why:
        raise TrackError.of(path, f"is no recording of JuPedSim: {why}") from None
    if not (fit := are_figures(rows).all(axis=1)).all():
        frame = rows[~fit][0, 1]
        raise TrackError.of(path, f"frame {frame:.0f} has a figure that is not within ±{LARGEST:g}")
    bodies = {}
    for agent in np.unique(rows[:, 0]):
        t, x, y, ori_x, ori_y = rows[rows[:, 0] == agent].T[1:]
        name = names.get(int(agent), f"{agent:.0f}")
        bodies[name] = Samples(t.astype(int), t, x, y, np.arctan2(ori_y, ori_x))
    return Tracks(bodies, counts_frames=True, frame_rate=rate, row="frame")


def _names(text: str) -> dict[int, str]:
    """Return the names of the agents who are people that were never put elsewhere."""
    agents = defaultdict(list)
    for agent in json.loads(text):
        agents[str(agent["person"])].append(int(agent["id"]))
    return {ids[0]: name for name, ids in agents.items() if len(ids) == 1}
