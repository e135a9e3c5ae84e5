"""The figures of a run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from navigation import Law, Motion, minimum_separation

from .gantry import GantryRobot
from .person import Person
from .recorder import rounded
from .referee import Referee
from .trial import Trial


def summarise(
    trial: Trial,
    now: float,
    *,
    interrupted: bool,
    people: Sequence[Person],
    gantry: GantryRobot | None,
    referee: Referee,
    motions: Mapping[str, Motion],
) -> dict[str, Any]:
    """The figures of a run that depend on nothing but the trial.

    `minimum_separation` is the nearest that anybody came to the gantry's centre: distance and
    required distance at that instant in metres, time in seconds. Times and distances of people
    count from their start.
    """
    nearest = {
        person.name: _nearest(
            motions[person.name], motions["gantry"], trial.rules.gantry_law, person.started_at, now
        )
        for person in people
        if gantry is not None and person.started_at is not None
    }
    summary: dict[str, Any] = {
        "trial": trial.name,
        "floorplan": trial.floorplan.name,
        "rules": trial.rules.name,
        "seed": trial.seed,
        "duration": now,
        "interrupted": interrupted,
        "penalties": referee.penalties,
        "agv_teleports": referee.agv_teleports,
        "gantry_disabled_time": gantry.disabled_time if gantry else 0.0,
        "jobs_done": gantry.jobs_done if gantry else 0,
        "minimum_separation": min(
            nearest.values(), key=lambda found: float(found["distance"]), default=None
        ),
        "people": {
            person.name: _person_figures(person, motions[person.name], now)
            | {"minimum_separation": nearest.get(person.name)}
            for person in people
        },
    }
    figures: dict[str, Any] = rounded(summary)
    return figures


def _nearest(
    person: Motion, gantry: Motion, law: Law, begin: float | None, end: float
) -> dict[str, float]:
    time, distance = minimum_separation(person, gantry, begin or 0.0, end)
    # A violation ends in a jump: what counts is how they moved until then.
    required = law.distance(person.state_before(time).speed, gantry.state_before(time).speed)
    return {"distance": distance, "time": time, "required": required}


def _person_figures(person: Person, motion: Motion, now: float) -> dict[str, Any]:
    begin = person.started_at
    walked = standing = 0.0
    for piece in motion.pieces if begin is not None else ():
        u = piece.end - piece.begin
        x, y = piece.x[1:], piece.y[1:]
        if any(x) or any(y):
            # A person's piece is straight and never turns back: its length is that of its chord.
            walked += math.hypot(
                u * (x[0] + u * (x[1] + u * x[2])), u * (y[0] + u * (y[1] + u * y[2]))
            )
        else:
            standing += max(0.0, piece.end - max(piece.begin, begin or 0.0))
    return {
        "personality": person.personality,
        "started": begin,
        "visits": person.visits,
        "distance_walked": walked,
        "time_standing": standing,
        "replans": person.walker.replans,
    }
