"""The AGVs as orders use them."""

from __future__ import annotations

from collections.abc import Iterable

from floorplan import Lane

from ..machines.agv.agv import Agv

TOLERANCE = 1e-6
"""Metres. How near to a location an AGV that stands there is."""


class Fleet:
    """Sends AGVs to where orders need them, and keeps them there."""

    def __init__(self, agvs: Iterable[Agv]) -> None:
        self._agvs = {agv.lane.name: agv for agv in agvs}
        self._sent: dict[str, str] = {}

    def lane(self, name: str) -> Lane:
        """The lane of an AGV."""
        return self._agvs[name].lane

    def serving(self, station: str) -> list[str]:
        """The AGVs that can go to an assembly station."""
        return [name for name, agv in self._agvs.items() if station in agv.lane.serves]

    def send(self, name: str, location: str) -> None:
        """Let an AGV go to a location, and come back to it whatever else it is told to do."""
        under_way = self._sent.get(name) == location and not self._agvs[name].stands
        self._sent[name] = location
        if not under_way and not self.is_at(name, location):
            self._agvs[name].drive(location)

    def release(self, name: str) -> None:
        """The AGV may go where it likes."""
        self._sent.pop(name, None)

    def is_at(self, name: str, location: str) -> bool:
        """Whether an AGV stands at a location."""
        agv = self._agvs[name]
        off = agv.lane_position - agv.lane.lane_position(location)
        return agv.stands and abs(off) < TOLERANCE

    def stopped(self, agv: Agv) -> None:
        """An AGV has come to rest: send it on if it should be elsewhere."""
        name = agv.lane.name
        if name in self._sent:
            self.send(name, self._sent[name])
