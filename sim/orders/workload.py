"""Orders of an ARIAC trial: parts, tasks, challenges and the workload."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from random import Random

from ..core.entries import Drop, OrderedWork, Start, seed_of

TYPES = ("battery", "pump", "regulator", "sensor")
"""Types of parts."""


COLORS = ("blue", "green", "orange", "purple", "red")
"""Colours of parts."""


@dataclass(frozen=True, order=True)
class PartType:
    """A kind of part: its colour and its type."""

    color: str
    type: str

    def __str__(self) -> str:
        return f"{self.color} {self.type}"


@dataclass(frozen=True)
class Item:
    """One part as it lies somewhere; one that is `faulty` looks like any other."""

    part: PartType
    flipped: bool = False
    faulty: bool = False


@dataclass(frozen=True)
class Load:
    """Load of an AGV: the id of its tray, and an item in each quadrant (1 to 4) that has one."""

    tray: int | None = None
    items: Mapping[int, Item] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class KittingTask:
    """Put a part into each quadrant of `products` on a tray, and send the AGV to `destination`."""

    agv: str
    tray: int
    destination: str
    products: Mapping[int, PartType]


@dataclass(frozen=True)
class AssemblyTask:
    """Insert `products`, which `agvs` bring, at `station`."""

    station: str
    agvs: tuple[str, ...]
    products: tuple[PartType, ...]


@dataclass(frozen=True)
class CombinedTask:
    """Make a kit of `products` on any AGV, and insert them at `station`."""

    station: str
    products: tuple[PartType, ...]


@dataclass(frozen=True)
class Order:
    """One order: its task, the condition of its announcement, and its priority."""

    id: str
    task: KittingTask | AssemblyTask | CombinedTask
    _: KW_ONLY
    announcement: Start = field(default_factory=Start)
    priority: bool = False

    @property
    def kind(self) -> str:
        """The kind of its task: kitting, assembly or combined."""
        return type(self.task).__name__.removesuffix("Task").lower()


@dataclass(frozen=True)
class Malfunction:
    """The ceiling robot stands for `seconds` from `start` on."""

    start: Start
    seconds: float


@dataclass(frozen=True)
class Conveyor:
    """Parts that come along the conveyor, one every `seconds`: an item each, and its place across.

    That is in metres from the middle of the belt. Where they come in `random_order`, it is drawn
    from the trial's seed.
    """

    parts: tuple[tuple[Item, float], ...] = ()
    seconds: float = 1.0
    random_order: bool = False

    def coming(self, seed: int) -> list[tuple[float, Item, float]]:
        """Return the instants (s) at which parts are put on it, the items, and their places."""
        parts = [*self.parts]
        if self.random_order:
            Random(seed_of(seed, "conveyor")).shuffle(parts)
        return [(self.seconds * k, *part) for k, part in enumerate(parts, start=1)]


@dataclass(frozen=True)
class ChallengePerson:
    """A person of the human challenge, who begins at `start`."""

    behavior: str
    start: Start


@dataclass(frozen=True)
class Workload(OrderedWork):
    """The work of an ARIAC trial.

    `bins` has the items in the slots (1 to 9) of each bin, `trays` the id of the tray in each
    slot (1 to 6) of the tray tables, `loads` what is on the AGVs at the start. `faulty` has the
    quadrants of kits in which the first part that is placed is faulty, by order; `drops` are the
    parts that the gripper loses; others come along the `conveyor`. `time_limit` is in seconds, None
    if there is none. `source` is the file it was read from, as the trial names it.
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
        """Names of all parts that can be, whether or not the trial has them."""
        return tuple(str(PartType(color, type)) for color in COLORS for type in TYPES)
