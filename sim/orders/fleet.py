"""The AGVs as orders use them."""

from __future__ import annotations

from collections.abc import Iterable

from floorplan import Lane

from ..machines.agv.agv import Agv

TOLERANCE = 1e-6
"""Metres. Distance to a location within which an AGV stands there."""


class Fleet:
    """Sends AGVs to where orders need them, and keeps them there."""

    def __init__(self, agvs: Iterable[Agv]) -> None:
        self._agvs = {agv.lane.name: agv for agv in agvs}
        self._sent: dict[str, str] = {}

    def lane(self, name: str) -> Lane:
        """Return the lane of an AGV."""
        return self._agvs[name].lane

    def serving(self, station: str) -> list[str]:
        """Return the AGVs that can go to an assembly station."""
        return [name for name, agv in self._agvs.items() if station in agv.lane.serves]

    def send(self, name: str, location: str) -> None:
        """Let an AGV go to a location, and come back to it after any other move."""
        under_way = self._sent.get(name) == location and not self._agvs[name].stands
        self._sent[name] = location
        if not under_way and not self.is_at(name, location):
            self._agvs[name].drive(location)

    def release(self, name: str) -> None:
        """Let an AGV go wherever its moves take it."""
        self._sent.pop(name, None)

    def is_at(self, name: str, location: str) -> bool:
        """Return True if an AGV stands at a location."""
        agv = self._agvs[name]
        off = agv.lane_position - agv.lane.lane_position(location)
        return agv.stands and abs(off) < TOLERANCE

    def stopped(self, agv: Agv) -> None:
        """Send on an AGV that has come to rest, if it should be elsewhere."""
        name = agv.lane.name
        if name in self._sent:
            self.send(name, self._sent[name])
