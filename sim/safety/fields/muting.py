"""Muting of the fields of a machine: when its axis is in a zone, and time spans."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from shapely.geometry import LinearRing

from floorplan import Zone
from navigation import FieldSet, Motion, ProtectiveFields, intrusions, standing

from ...core.body import Body
from ...core.clock import Alarm, Turn
from ...core.schedule import Interval, within
from .watch import MOMENT

POINT = 1e-9
"""Metres. Radius of the axis of a machine."""


class MutingWatch:
    """Calls `changed` when the muting of fields begins and ends. `active` is the present state."""

    def __init__(
        self,
        body: Body,
        zones: Iterable[Zone],
        times: tuple[Interval, ...],
        changed: Callable[[], None],
    ) -> None:
        self.active = False
        self._body = body
        self._clock = body.clock
        # The entry of the axis into a zone is solved like an intrusion into a field at rest.
        self._areas = [
            (_area(zone.area.exterior), [_area(hole) for hole in zone.area.interiors])
            for zone in zones
        ]
        self._times = times
        self._changed = changed
        self._alarm = Alarm(body.clock, self.reconsider, Turn.VIOLATION)

    def reconsider(self) -> None:
        """Compute whether it is active, and when that changes. It is called for each new motion."""
        now, motion = self._clock.now, self._body.motion
        active = within(self._times, now)
        changes = [t for span in self._times for t in span if t > now]
        end = max(now, motion.end) + 1.0
        for area, holes in self._areas:
            spans = _inside(area, motion, now, end)
            for hole in holes:
                spans = _without(spans, _inside(hole, motion, now, end))
            for begin, until in spans:
                active = active or begin <= now + MOMENT < until
                changes += [t for t in (begin, until) if now + MOMENT < t < end]
        self._alarm.set(min(changes, default=None))
        if active != self.active:
            self.active = active
            self._changed()


def _area(ring: LinearRing) -> ProtectiveFields:
    corners = tuple(ring.coords[:-1])
    return ProtectiveFields(sets=(FieldSet(name="zone", protective=corners),))


def _inside(
    area: ProtectiveFields, motion: Motion, begin: float, end: float
) -> list[tuple[float, float]]:
    """Return the time spans (s) in which a motion is within an area."""
    return [
        (intrusion.begin, intrusion.end)
        for intrusion in intrusions(area, standing((0.0, 0.0)), motion, POINT, begin, end)
    ]


def _without(
    spans: list[tuple[float, float]], gaps: list[tuple[float, float]]
) -> list[tuple[float, float]]:
    """Return the parts of time spans outside gaps."""
    for since, until in gaps:
        parts = [((begin, min(end, since)), (max(begin, until), end)) for begin, end in spans]
        spans = [part for pair in parts for part in pair if part[0] < part[1]]
    return spans
