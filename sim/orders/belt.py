"""The conveyor: parts that come along it, are picked from it, or fall off its end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from floorplan import Floorplan
from navigation import Motion
from navigation.motion import Piece

from ..core.events import PartCame, PartMissed, PartTaken
from ..core.stage import Stage
from ..core.workload import Conveyor, Item, Part
from ..machines.gantry.tasks import Passing, Step
from .layout import BELT, BELT_SPEED, belt_ends


@dataclass(eq=False)
class _Conveyed:
    number: int
    item: Item
    passing: Passing
    promised: bool = False
    is_gone: bool = False


class Belt:
    """Parts on the conveyor: where each of them is follows from when it was put on.

    An order has parts promised, also such as are yet to come. `missed(passing)` is called for
    those that fall off.
    """

    def __init__(
        self, stage: Stage, conveyor: Conveyor, seed: int, missed: Callable[[Passing], None]
    ) -> None:
        self._stage = stage
        self._missed = missed
        self.parts_missed = 0
        self._parts = [
            _Conveyed(number, item, Passing(track, partial(self._taken, number)))
            for number, (time, item, across) in enumerate(conveyor.coming(seed))
            for track in [track_of(stage.floorplan, time, across)]
        ]

    def begin(self, came: Callable[[], None]) -> None:
        """Let parts come, each at its time; `came()` is called then."""
        for one in self._parts:
            self._stage.clock.call_at(one.passing.track.start, partial(self._came, one, came))
            self._stage.clock.call_at(one.passing.track.end, partial(self._fall, one))

    def take(self, part: Part) -> tuple[int, Item] | None:
        """Promise the next such part that is there or comes; return its number and the item."""
        for one in self._parts:
            if one.item.part == part and not (one.promised or one.is_gone):
                one.promised = True
                return one.number, one.item
        return None

    def step(self, number: int, seconds: float) -> Step:
        """Return the step of picking a part from the belt."""
        return Step("pick", seconds, place=BELT, passing=self._parts[number].passing)

    def has_come(self, passing: Passing) -> bool:
        """Return whether a part is on the belt, or has been."""
        return passing.track.start <= self._stage.clock.now

    def _came(self, one: _Conveyed, came: Callable[[], None]) -> None:
        track = one.passing.track
        at, to = (track.state(t).at for t in (track.start, track.end))
        part = str(one.item.part)
        self._stage.record(PartCame(part=part, number=one.number, at=at, to=to, falls=track.end))
        came()

    def _taken(self, number: int) -> None:
        one = self._parts[number]
        one.is_gone = True
        at = one.passing.track.state(self._stage.clock.now).at
        self._stage.record(PartTaken(part=str(one.item.part), number=number, at=at))

    def _fall(self, one: _Conveyed) -> None:
        if not one.is_gone:
            one.is_gone = True
            self.parts_missed += 1
            at = one.passing.track.state(self._stage.clock.now).at
            self._stage.record(PartMissed(part=str(one.item.part), number=one.number, at=at))
            self._missed(one.passing)


def track_of(plan: Floorplan, time: float, across: float) -> Motion:
    """Return the motion of a part that is put on at `time` (s), `across` metres from the middle."""
    (x, begin), (_, end) = belt_ends(plan)
    seconds = (begin - end) / BELT_SPEED
    x_of, y_of = (x + across, 0.0, 0.0, 0.0), (begin, -BELT_SPEED, 0.0, 0.0)
    return Motion((Piece(time, time + seconds, x_of, y_of, (0.0, 0.0, 0.0, 0.0)),))
