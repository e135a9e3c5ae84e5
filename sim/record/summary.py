"""The figures of a run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from navigation import Motion, minimum_separation

from ..core.recorder import rounded
from ..core.scenario import Scenario
from ..machines.gantry.robot import GantryRobot
from ..people.person import Person
from ..safety.law_audit import short_laws
from ..safety.referee import Referee
from ..safety.watches import Cause, SeparationWatch


def summarise(
    trial: Scenario,
    now: float,
    *,
    interrupted: bool,
    people: Sequence[Person],
    gantry: GantryRobot | None,
    referee: Referee,
    motions: Mapping[str, Motion],
    work: Mapping[str, Any],
) -> dict[str, Any]:
    """The figures of a run that depend on nothing but the trial.

    `minimum_separation` is the nearest that anybody came to the gantry's centre: distance and
    required distance at that instant in metres, time in seconds. `violations` with the gantry are
    counted by cause. Times and distances of people count from their start. `work` are the figures
    of orders, where there are any. `law_audit` has a `ShortLaw` for each machine whose law counts
    on a shorter stop than it may take.
    """
    started = {person.name: person.started_at for person in people}
    nearest = {
        watch.pair.person.name: _nearest(watch, motions, begin, now)
        for watch in referee.watches
        if watch.pair.machine.kind == "gantry"
        and (begin := started[watch.pair.person.name]) is not None
    }
    summary: dict[str, Any] = {
        "trial": trial.name,
        "floorplan": trial.floorplan.name,
        "rules": trial.rules.name,
        "seed": trial.seed,
        "duration": now,
        "interrupted": interrupted,
        "penalties": referee.penalties,
        "violations": _violations(referee.violations, None),
        "agv_violations": sum(n for (_, cause), n in referee.violations.items() if cause == "agv"),
        "agv_teleports": referee.agv_teleports,
        "protective_stops": referee.protective_stops,
        "protective_stop_time": referee.protective_stop_time,
        **_gantry_figures(gantry, motions, now),
        **work,
        "law_audit": [asdict(short) for short in short_laws(trial)],
        "minimum_separation": min(
            nearest.values(), key=lambda found: float(found["distance"]), default=None
        ),
        "people": {
            person.name: _person_figures(person, motions[person.name], now)
            | {"violations": _violations(referee.violations, person.name)}
            | {"minimum_separation": nearest.get(person.name)}
            for person in people
        },
    }
    figures: dict[str, Any] = rounded(summary)
    return figures


def _gantry_figures(
    gantry: GantryRobot | None, motions: Mapping[str, Motion], now: float
) -> dict[str, Any]:
    """What the gantry did; it is idle while it neither moves, handles nor is made to stand."""
    if gantry is None:
        return {"gantry_disabled_time": 0.0, "gantry_idle_time": 0.0, "jobs_done": 0}
    drive = gantry.drive
    moving = sum(
        piece.end - piece.begin
        for piece in motions["gantry"].pieces
        if any(any(axis[1:]) for axis in (piece.x, piece.y, piece.rotation))
    )
    # While it brakes because it is made to stand, both count.
    busy = moving - drive.braking_time + drive.working_time + drive.standing_time
    return {
        "gantry_disabled_time": drive.disabled_time,
        "gantry_idle_time": max(0.0, now - busy),
        "jobs_done": gantry.jobs_done,
    }


def _nearest(
    watch: SeparationWatch, motions: Mapping[str, Motion], begin: float, end: float
) -> dict[str, float]:
    tracks = (motions[watch.pair.person.name], motions[watch.pair.machine.name])
    time, distance = minimum_separation(*tracks, begin, end)
    # A violation ends in a jump: what counts is what they were about to do until then.
    return {
        "distance": distance,
        "time": time,
        "required": watch.required_before(time, *tracks),
    }


def _violations(counts: Mapping[tuple[str, Cause], int], person: str | None) -> dict[str, int]:
    """Return how many violations with the gantry had which cause: of all people, or of one."""
    causes: tuple[Cause, ...] = ("gantry", "person")
    return {
        cause: sum(
            count for (who, why), count in counts.items() if why == cause and person in (who, None)
        )
        for cause in causes
    }


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
