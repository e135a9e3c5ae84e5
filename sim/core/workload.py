"""Workload of an ARIAC trial: its orders, and the parts and trays to fill them with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from random import Random

from .blackout import Blackout
from .seeds import seed_of
from .start import Start

TYPES = ("battery", "pump", "regulator", "sensor")
"""Types of parts."""

COLORS = ("blue", "green", "orange", "purple", "red")
"""Colours of parts."""


@dataclass(frozen=True, order=True)
class Part:
    """A kind of part: its colour and its type."""

    color: str
    type: str

    def __str__(self) -> str:
        return f"{self.color} {self.type}"


@dataclass(frozen=True)
class Item:
    """One part as it lies somewhere; one that is `faulty` looks like any other."""

    part: Part
    flipped: bool = False
    faulty: bool = False


@dataclass(frozen=True)
class Load:
    """Load of an AGV: the id of its tray, and an item in each quadrant (1 to 4) that has one."""

    tray: int | None = None
    items: Mapping[int, Item] = field(default_factory=dict)


@dataclass(frozen=True)
class KittingTask:
    """Put a part into each quadrant of `products` on a tray, and send the AGV to `destination`."""

    agv: str
    tray: int
    destination: str
    products: Mapping[int, Part]


@dataclass(frozen=True)
class AssemblyTask:
    """Insert `products`, which `agvs` bring, at `station`."""

    station: str
    agvs: tuple[str, ...]
    products: tuple[Part, ...]


@dataclass(frozen=True)
class CombinedTask:
    """Make a kit of `products` on any AGV, and insert them at `station`."""

    station: str
    products: tuple[Part, ...]


@dataclass(frozen=True)
class Order:
    """One order: its task, the condition of its announcement, and its priority."""

    id: str
    task: KittingTask | AssemblyTask | CombinedTask
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
class Drop:
    """The gripper loses a `part` once, `delay` seconds after it was picked, if it still holds it.

    That is the next one of its name once `after` of them were picked.
    """

    part: str
    after: int = 0
    delay: float = 0.0


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
class Human:
    """A person of the human challenge, who begins at `start`."""

    behavior: str
    start: Start


@dataclass(frozen=True)
class Workload:
    """The work of an ARIAC trial.

    `bins` has the items in the slots (1 to 9) of each bin, `trays` the id of the tray in each
    slot (1 to 6) of the tray tables, `loads` what is on the AGVs at the start. `faulty` has the
    quadrants of kits in which the first part that is placed is faulty, by order; `drops` are the
    parts that the gripper loses; others come along the `conveyor`. `time_limit` is in seconds, None
    if there is none. `source` is the file it was read from, as the trial names it.
    """

    orders: tuple[Order, ...]
    bins: Mapping[str, Mapping[int, Item]] = field(default_factory=dict)
    trays: Mapping[int, int] = field(default_factory=dict)
    loads: Mapping[str, Load] = field(default_factory=dict)
    malfunctions: tuple[Malfunction, ...] = ()
    humans: tuple[Human, ...] = ()
    faulty: Mapping[str, frozenset[int]] = field(default_factory=dict)
    drops: tuple[Drop, ...] = ()
    conveyor: Conveyor = Conveyor()
    blackouts: tuple[Blackout, ...] = ()
    time_limit: float | None = None
    source: str = field(default="", compare=False)

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of all parts that can be, whether or not the trial has them."""
        return tuple(str(Part(color, type)) for color in COLORS for type in TYPES)
