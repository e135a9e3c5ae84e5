"""A floor on top of another: the base, corrected, with stations and machines laid over it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from typing import TypeVar

import shapely

from .model import Door, Gate, Obstacle, Station, Zone
from .plan import Floorplan
from .problems import suggestion
from .schema import FloorplanSchema
from .validation import Fault

_Thing = TypeVar("_Thing", Obstacle, Station, Door, Zone, Gate)


_FIELDS = {
    **{key: key for key in ("title", "source", "boundary", "patrol", "safe_zone", "human")},
    "agvs": "lanes",
    "gantry": "gantry",
}
"""Fields of a floor that take the place of the base's, by their keys in a file."""


def corrected(base: Floorplan, schema: FloorplanSchema, metre: float) -> Floorplan:
    """Return `base` without what is removed, and with what is moved and renamed.

    All by the names that the obstacles have in `base`; distances are in units of `metre` metres.
    """
    kept = []
    for obstacle in base.obstacles:
        name = obstacle.name
        if any(fnmatchcase(name, pattern) for pattern in schema.remove):
            continue
        if name in schema.move:
            dx, dy = (d * metre for d in schema.move[name])
            footprint = shapely.transform(obstacle.footprint, lambda at, d=(dx, dy): at + d)
            obstacle = replace(obstacle, footprint=footprint)
        kept.append(replace(obstacle, name=schema.rename.get(name, name)))
    return replace(base, obstacles=kept)


def correction_faults(base: Floorplan, schema: FloorplanSchema) -> Iterator[Fault]:
    """Yield the corrections that are about nothing in `base`, or contradict each other."""
    names = [obstacle.name for obstacle in base.obstacles]
    removed = set()
    for k, pattern in enumerate(schema.remove):
        met = {name for name in names if fnmatchcase(name, pattern)}
        removed |= met
        if not met:
            yield _unknown(pattern, names), ("remove", k)
    for key, given in (("move", schema.move), ("rename", schema.rename)):
        for name in given:
            if name not in names:
                yield _unknown(name, names), (key, name)
            elif name in removed:
                yield f"{name!r} is removed as well", (key, name)


def _unknown(name: str, names: Sequence[str]) -> str:
    hint = suggestion(name, names) if names else "it has none"
    return f"no obstacle of the base is called {name!r}; {hint}"


def laid_over(base: Floorplan, top: Floorplan, given: Iterable[str]) -> Floorplan:
    """Return `base` with `top` over it; `given` are the keys that `top` has.

    Of two things of one kind and name, that of `top` stands.
    """
    laid = {_FIELDS[key]: getattr(top, _FIELDS[key]) for key in given if key in _FIELDS}
    return replace(
        base,
        name=top.name,
        obstacles=_replaced(base.obstacles, top.obstacles),
        stations=_replaced(base.stations, top.stations),
        doors=_replaced(base.doors, top.doors),
        zones=_replaced(base.zones, top.zones),
        gates=_replaced(base.gates, top.gates),
        **laid,
    )


def _replaced(below: Sequence[_Thing], above: Sequence[_Thing]) -> list[_Thing]:
    over = [thing.name for thing in above]
    return [thing for thing in below if thing.name not in over] + list(above)
