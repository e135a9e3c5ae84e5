"""Orders of an ARIAC trial: parts, tasks, challenges and the workload."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, field
from random import Random

from floorplan.files.dataclass import dataclass

from ..core.entries import Drop, OrderedWork, Start, seed_of

TYPES = ("battery", "pump", "regulator", "sensor")
"""Types of parts."""


COLORS = ("blue", "green", "orange", "purple", "red")
"""Colours of parts."""


@dataclass(frozen=True, order=True)
class PartType:
    """Type of part with its colour."""

    color: str
    type: str

    def __str__(self) -> str:
        return f"{self.color} {self.type}"


@dataclass(frozen=True)
class Item:
    """Part at a place. Faulty parts look like others."""

    part: PartType
    flipped: bool = False
    faulty: bool = False


@dataclass(frozen=True)
class Load:
    """Load of an AGV: the id of its tray, and the items by quadrant (1 to 4)."""

    tray: int | None = None
    items: Mapping[int, Item] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class KittingTask:
    """Task to put a part into each quadrant of `products` on a tray, and send the AGV away."""

    agv: str
    tray: int
    destination: str
    products: Mapping[int, PartType]


@dataclass(frozen=True)
class AssemblyTask:
    """Task to insert `products` from `agvs` at `station`."""

    station: str
    agvs: tuple[str, ...]
    products: tuple[PartType, ...]


@dataclass(frozen=True)
class CombinedTask:
    """Task to make a kit of `products` on any AGV, and insert them at `station`."""

    station: str
    products: tuple[PartType, ...]


@dataclass(frozen=True)
class Order:
    """Order: its task, the condition of its announcement, and its priority."""

    id: str
    task: KittingTask | AssemblyTask | CombinedTask
    _: KW_ONLY
    announcement: Start = field(default_factory=Start)
    priority: bool = False

    @property
    def kind(self) -> str:
        """Kind of its task: kitting, assembly or combined."""
        return type(self.task).__name__.removesuffix("Task").lower()


@dataclass(frozen=True)
class Malfunction:
    """Malfunction of the ceiling robot, for `seconds` from `start`."""

    start: Start
    seconds: float


@dataclass(frozen=True)
class Conveyor:
    """Parts on the conveyor, one every `seconds`: items with their offsets.

    Offsets are in metres from the middle of the belt. A `random_order` is drawn from the trial's
    seed.
    """

    parts: tuple[tuple[Item, float], ...] = ()
    seconds: float = 1.0
    random_order: bool = False

    def coming(self, seed: int) -> list[tuple[float, Item, float]]:
        """Return the times (s) at which parts appear, the items, and their offsets (m)."""
        parts = [*self.parts]
        if self.random_order:
            Random(seed_of(seed, "conveyor")).shuffle(parts)
        return [(self.seconds * k, *part) for k, part in enumerate(parts, start=1)]


@dataclass(frozen=True)
class ChallengePerson:
    """Person of the human challenge, who starts at `start`."""

    behavior: str
    start: Start


@dataclass(frozen=True)
class Workload(OrderedWork):
    """Orders and parts of an ARIAC trial.

    `bins` has the items in the slots (1 to 9) of each bin, `trays` the id of the tray in each slot
    (1 to 6) of the tray tables, and `loads` the initial loads of AGVs. `faulty` has the quadrants
    of each order in which the first placed part is faulty. The gripper loses the parts of `drops`.
    `time_limit` is in seconds, None if there is none.
    """

    orders: tuple[Order, ...]
    _: KW_ONLY
    bins: Mapping[str, Mapping[int, Item]] = field(default_factory=dict)
    trays: Mapping[int, int] = field(default_factory=dict)
    loads: Mapping[str, Load] = field(default_factory=dict)
    malfunctions: tuple[Malfunction, ...] = ()
    humans: tuple[ChallengePerson, ...] = ()
    faulty: Mapping[str, frozenset[int]] = field(default_factory=dict)
    drops: tuple[Drop, ...] = ()
    conveyor: Conveyor = Conveyor()
    time_limit: float | None = None

    @property
    def ids(self) -> tuple[str, ...]:
        """Names of the orders."""
        return tuple(order.id for order in self.orders)

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of all possible parts."""
        return tuple(str(PartType(color, type)) for color in COLORS for type in TYPES)
