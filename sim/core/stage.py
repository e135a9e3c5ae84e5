"""The stage of a trial: everything that people and machines share while it runs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from floorplan import Floorplan, Obstacle, Point
from navigation import CollisionWorld, Motion

from .body import Body
from .clock import Clock
from .closures import Closures
from .events import DoorClosed, DoorOpened, EventKind, ObstacleCame, ObstacleWent
from .machine import Machine
from .recorder import Record
from .rules import RuleSet
from .triggers import Triggers


class Bystander(Protocol):
    """A person as the referee and machines know them."""

    @property
    def name(self) -> str:
        """Their name."""
        ...

    @property
    def body(self) -> Body:
        """Their body."""
        ...

    @property
    def is_recorded(self) -> bool:
        """True of somebody who walks as they were measured: nobody can put them elsewhere."""
        ...

    @property
    def away(self) -> bool:
        """Whether they are not on the floor: not yet, or not any more."""
        ...

    @property
    def reaction_time(self) -> float:
        """Seconds from when they see something until they perceive it."""
        ...

    def sees(self, machine: Machine) -> bool:
        """Return whether they can see `machine` now."""
        ...

    def warn(self, percept: str, machine: Machine) -> None:
        """Perceive `percept` about a machine, and go home for a violation."""
        ...

    def floor_changed(self, came: Collection[str]) -> None:
        """Take note that something has come to be, or is no longer, in people's way.

        `came` are the names of what stands since now where it did not before.
        """
        ...

    def send(self, to: Point) -> bool:
        """Walk to a place, or near it; return whether they set out."""
        ...


@dataclass(eq=False, kw_only=True)
class Stage:
    """State that everybody in a simulation shares.

    `people` and `machines` are there from the beginning, each complete before anybody acts;
    `fastest` (m/s) is the highest speed of people. Machines that come to rest say so by
    `came_to_rest`. `closures` are what is not always there; `there` is what of it is there now.
    """

    floorplan: Floorplan
    rules: RuleSet
    folder: Path
    end: float
    clock: Clock
    record: Record
    triggers: Triggers
    world: CollisionWorld
    fastest: float
    own_code: bool = True
    people: Sequence[Bystander] = ()
    machines: dict[str, Machine] = field(default_factory=dict)
    on_rest: list[Callable[[Machine], None]] = field(default_factory=list)
    """Called whenever a machine has come to rest, after people and before machines take note."""
    closures: Closures | None = None
    there: dict[str, Obstacle] = field(default_factory=dict)
    placed: dict[str, Obstacle] = field(default_factory=dict)
    """What was put down by command, by name; it is `there` as well."""
    blind: Counter[str] = field(default_factory=Counter)
    """Number of blackouts in which a machine is now, by its name."""

    def __post_init__(self) -> None:
        """Put what is there at the start into the world of those who may go everywhere."""
        self._worlds = {self._rules_for(""): self._furnish(self.world, "")}
        self._at_rest: dict[Machine, Motion] = {}
        if self.closures is not None:
            self._set(self.closures.at(self.clock.now))

    def begin(self) -> None:
        """Let doors open and close, and obstacles come and go, at their times."""
        self._report(self.there, is_there=True)
        if self.closures is not None:
            for t in self.closures.changes(self.end):
                self.clock.call_at(t, self._change)

    def world_of(self, person: str) -> CollisionWorld:
        """Return the world of a person, in which zones that are forbidden to them are closed.

        One-way gates hold that bind them.
        """
        rules = self._rules_for(person)
        if rules not in self._worlds:
            gates = [gate for gate in self.floorplan.one_ways if gate.is_about(person)]
            world = self._furnish(CollisionWorld(self.floorplan, gates=gates), person)
            for one in self.there.values():
                world.place(one.name, one.footprint, one.bottom, one.top)
            for machine in self.vehicles:
                machine.stand_in(world)
            self._worlds[rules] = world
        return self._worlds[rules]

    @property
    def vehicles(self) -> Iterable[Machine]:
        """The machines that drive on the floor, and can block people's paths."""
        return (m for m in self.machines.values() if m.shape.category == "vehicle")

    @property
    def robots(self) -> Iterable[Machine]:
        """The machines that work above the floor."""
        return (m for m in self.machines.values() if m.shape.category == "robot")

    def came_to_rest(self, machine: Machine) -> None:
        """Let everybody see that a machine has come to rest on the floor."""
        self.place_machines()
        for person in self.people:
            person.floor_changed((machine.name,))
        for notified in self.on_rest:
            notified(machine)
        for other in self.machines.values():
            other.floor_changed()

    def place_machines(self) -> None:
        """Put the machines of the collision world where they are now."""
        for machine in self.vehicles:
            motion = machine.body.motion
            if self._at_rest.get(machine) is motion:
                continue  # it stands where it was put
            for world in self._worlds.values():
                machine.stand_in(world)
            if motion.end <= self.clock.now:
                self._at_rest[machine] = motion

    def put_down(self, obstacle: Obstacle) -> None:
        """Let an obstacle be there from now on, until it is taken up."""
        self.placed[obstacle.name] = obstacle
        self._change()

    def take_up(self, name: str) -> None:
        """Take away an obstacle that was put down."""
        self.placed.pop(name, None)
        self._change()

    def _rules_for(self, person: str) -> frozenset[str]:
        """Return the zones in which a person may not be, and the one-way gates that bind them.

        Nobody in particular is called "".
        """
        plan = self.floorplan
        zones = {zone.name for zone in plan.zones if zone.forbidden and zone.is_about(person)}
        return frozenset(zones | {gate.name for gate in plan.one_ways if gate.is_about(person)})

    def _furnish(self, world: CollisionWorld, person: str) -> CollisionWorld:
        for zone in self.floorplan.zones:
            if zone.forbidden and zone.is_about(person):
                world.place(zone.name, zone.area)
        return world

    def _set(self, there: dict[str, Obstacle]) -> None:
        """Let these obstacles be there, and no others of those that come and go."""
        for world in self._worlds.values():
            for name in self.there.keys() - there.keys():
                if name in {body.name for body in world.bodies}:
                    world.remove(name)
            for name in sorted(there.keys() - self.there.keys()):
                one = there[name]
                world.place(name, one.footprint, one.bottom, one.top)
        self.there = there

    def _report(self, names: Iterable[str], *, is_there: bool) -> None:
        """Record that these closures are there from now on, or no longer."""
        doors = {door.name for door in self.floorplan.doors}
        for name in sorted(names):
            event: EventKind
            if name in doors:
                event = DoorClosed(door=name) if is_there else DoorOpened(door=name)
            else:
                event = ObstacleCame(obstacle=name) if is_there else ObstacleWent(obstacle=name)
            self.record(event)

    def _change(self) -> None:
        """Let everything be as it is from now on, and everybody see that."""
        timed = {} if self.closures is None else self.closures.at(self.clock.now)
        before, there = self.there, timed | self.placed
        if before.keys() == there.keys():
            return
        self._set(there)
        came = there.keys() - before.keys()
        self._report(before.keys() - there.keys(), is_there=False)
        self._report(came, is_there=True)
        self.place_machines()
        for person in self.people:
            person.floor_changed(came)
        for machine in self.machines.values():
            machine.floor_changed()
