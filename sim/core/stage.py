"""Stage of a trial: shared state of people and machines, closures, triggers, machine models."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from pydantic import ConfigDict
from shapely.geometry import Polygon
from typing_extensions import Self

from floorplan import Door, Floorplan, Obstacle, Point, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import brief
from floorplan.files.problems import Fault, suggestion
from navigation import CollisionWorld, Motion, VehicleLimits
from navigation.machines import AxisLimits, Stop

from .body import Body, Category, Machine, MachineShape
from .clock import Clock, InProgress
from .custom_code import CodeFolder
from .entries import Start
from .events import DoorClosed, DoorOpened, EventKind, ObstacleCame, ObstacleWent
from .recorder import Event, Record
from .rules import RuleSet
from .schedule import DoorTimes, Interval, TimedObstacle, within

if TYPE_CHECKING:
    from pydantic import TypeAdapter


@dataclass(frozen=True)
class Closures:
    """Obstacles that are not always present: closed doors and timed obstacles."""

    plan: Floorplan
    doors: dict[str, DoorTimes]
    timed: tuple[TimedObstacle, ...]

    def at(self, t: float) -> dict[str, Obstacle]:
        """Return the obstacles present at `t` (s), by name."""
        shut = (door.closed for door in self.plan.doors if not self._is_open(door, t))
        there = (one.obstacle for one in self.timed if within(one.there, t))
        return {one.name: one for one in (*shut, *there)}

    def changes(self, end: float) -> list[float]:
        """Return the instants from 0 to `end` (seconds) at which something may change."""
        spans = [times.intervals for times in self.doors.values()]
        spans += [one.there for one in self.timed]
        return sorted({t for t in _edges(spans) if 0 < t < end})

    def _is_open(self, door: Door, t: float) -> bool:
        times = self.doors.get(door.name)
        return door.is_open if times is None else times.is_open(t)


def _edges(spans: Iterable[tuple[Interval, ...]]) -> Iterator[float]:
    return (t for intervals in spans for interval in intervals for t in interval)


Action = Callable[[], None]


@dataclass
class _Waiting:
    """Person waiting for `start`, which has occurred `count` times."""

    start: Start
    who: str | None
    action: Action
    count: int = 0


class Triggers:
    """Calls each action once, when its condition is met."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._waiting: list[_Waiting] = []
        self._each: dict[str, list[Callable[[Event], None]]] = {}

    def add(self, start: Start, action: Action, who: str | None = None) -> None:
        """Call `action` when the condition `start` of the person `who` is met."""
        if start.time is not None:
            self._clock.call_at(start.time, action)
        else:
            self._waiting.append(_Waiting(start, who, action))

    def each(self, kind: str, action: Callable[[Event], None]) -> None:
        """Call `action` with every event of this kind from now on."""
        self._each.setdefault(kind, []).append(action)

    def notify(self, event: Event) -> None:
        """Call the actions that have waited for the event, in the order of their waiting."""
        for action in self._each.get(event["kind"], ()):
            action(event)
        due = []
        for waiting in self._waiting:
            if _is(event, waiting.start, waiting.who):
                waiting.count += 1
                if waiting.count == waiting.start.count:
                    due.append(waiting)
        if due:
            # Remove them before the actions, which may add others or cause events.
            self._waiting = [waiting for waiting in self._waiting if waiting not in due]
        for waiting in due:
            waiting.action()


def _is(event: Event, start: Start, who: str | None) -> bool:
    kind: str = event["kind"]
    if start.event is not None:
        person = start.person or who
        return kind == start.event and event.get("person", person) == person
    if start.order_submitted is not None:
        return kind == "order_submitted" and start.order_submitted == str(event["order"])
    if start.part_placed is None or kind != "job_done" or event["job"] != "pick_place":
        return False
    return start.part_placed.items() <= {"part": event["part"], "agv": event["to"]}.items()


class Bystander(Protocol):
    """Person as seen by the referee and machines."""

    @property
    def name(self) -> str:
        """Name of the person."""
        ...

    @property
    def body(self) -> Body:
        """Body of the person."""
        ...

    @property
    def radius(self) -> float:
        """Radius of the body in metres."""
        ...

    @property
    def is_recorded(self) -> bool:
        """Whether the person follows a recorded track, and cannot be moved elsewhere."""
        ...

    @property
    def started_at(self) -> float | None:
        """Time of the start in seconds."""
        ...

    @property
    def away(self) -> bool:
        """Whether the person is not on the floor now."""
        ...

    @property
    def reaction_time(self) -> float:
        """Seconds between seeing and perceiving."""
        ...

    def sees(self, machine: Machine) -> bool:
        """Return whether the person can see `machine` now."""
        ...

    def warn(self, percept: str, machine: Machine) -> None:
        """Add a percept about a machine. After a violation, the person goes home."""
        ...

    def floor_changed(self, came: Collection[str]) -> None:
        """Replan after obstacles were added or removed.

        `came` has the names of the added ones.
        """
        ...

    def send(self, to: Point) -> bool:
        """Walk to a place, or near it. Return whether the person starts."""
        ...


class Machines(dict[str, Machine]):
    """Machines by name. `UserError` for an unknown name."""

    def __missing__(self, name: object) -> Machine:
        """Raise `UserError` with the most similar name."""
        raise UserError(f"there is no machine {name!r}; {suggestion(str(name), self)}")


@dataclass(eq=False, kw_only=True)
class Stage(InProgress):
    """State shared by people and machines in a running simulation.

    Parameters
    ----------
    floorplan : Floorplan
        The floor.
    rules : RuleSet
        Rules of the trial.
    code_folder : CodeFolder
        Folder of the trial, and whether its custom code is allowed.
    end : float
        Duration of the trial in seconds.
    clock : Clock
        Clock of the simulation.
    record : callable
        Function that records an `EventKind`.
    triggers : Triggers
        Conditions that wait for events.
    world : CollisionWorld
        Collision world without restricted zones and gates.
    fastest, widest : float
        Highest speed of people in m/s, and their largest radius in metres.
    people : sequence of Bystander, optional
        People. All are complete before the first one acts.
    on_rest : list of callable, optional
        Callbacks for each machine that has stopped, called after people and before machines are
        notified.
    closures : Closures, optional
        Times at which doors and obstacles open and close.
    active_closures, placed : dict, optional
        Obstacles that exist now and may disappear, by name. `placed` are those added by commands.
    blind : Counter, optional
        Number of active blackouts of each machine, by name.
    on_blackout : list of callable, optional
        Callbacks with the name of the machine for each begin and end of its blackout.
    """

    floorplan: Floorplan
    rules: RuleSet
    code_folder: CodeFolder
    end: float
    clock: Clock
    record: Record
    triggers: Triggers
    world: CollisionWorld
    fastest: float
    widest: float
    people: Sequence[Bystander] = ()
    machines: dict[str, Machine] = field(default_factory=Machines, init=False)
    """Machines by name. All are complete before the first one acts."""
    vehicles: tuple[Machine, ...] = field(default=(), init=False)
    """Machines that drive on the floor and can block paths."""
    robots: tuple[Machine, ...] = field(default=(), init=False)
    """Machines that work above the floor."""
    on_rest: list[Callable[[Machine], None]] = field(default_factory=list)
    """Callbacks for each machine that has stopped, called before machines are notified."""
    closures: Closures | None = None
    active_closures: dict[str, Obstacle] = field(default_factory=dict)
    placed: dict[str, Obstacle] = field(default_factory=dict)
    """Obstacles that were added by commands, by name. They are also in `active_closures`."""
    blind: Counter[str] = field(default_factory=Counter)
    """Number of active blackouts of each machine, by name."""
    on_blackout: list[Callable[[str], None]] = field(default_factory=list)
    """Callbacks with the name of a machine whose blackout begins or ends."""

    def __post_init__(self) -> None:
        """Add the initial closures to the collision world without restricted zones."""
        self._worlds = {self._rules_for(""): self._furnish(self.world, "")}
        self._at_rest: dict[Machine, Motion] = {}
        if self.closures is not None:
            self._set(self.closures.at(self.clock.now))

    def begin(self) -> None:
        """Schedule the changes of doors and timed obstacles."""
        self._report(self.active_closures, is_there=True)
        if self.closures is not None:
            for t in self.closures.changes(self.end):
                self.clock.call_at(t, self._change)

    def world_of(self, person: str) -> CollisionWorld:
        """Return the collision world of a person.

        It includes the zones that are closed and the one-way gates that apply to the person.

        Parameters
        ----------
        person : str
            Name of the person.
        """
        rules = self._rules_for(person)
        if rules not in self._worlds:
            gates = [gate for gate in self.floorplan.one_ways if gate.is_about(person)]
            world = self._furnish(CollisionWorld(self.floorplan, gates=gates), person)
            for one in self.active_closures.values():
                world.place(one.name, one.footprint, one.bottom, one.top)
            for machine in self.vehicles:
                machine.stand_in(world)
            self._worlds[rules] = world
        return self._worlds[rules]

    def add(self, machine: Machine) -> None:
        """Add a machine to the stage.

        Parameters
        ----------
        machine : Machine
            The machine.
        """
        self.machines[machine.name] = machine
        if machine.shape.category == "vehicle":
            self.vehicles += (machine,)
        else:
            self.robots += (machine,)

    def came_to_rest(self, machine: Machine) -> None:
        """Notify people and machines that a machine has stopped on the floor.

        Parameters
        ----------
        machine : Machine
            The machine.
        """
        self.place_machines()
        for person in self.people:
            person.floor_changed((machine.name,))
        for notified in self.on_rest:
            notified(machine)
        for other in self.machines.values():
            other.floor_changed()

    def place_machines(self) -> None:
        """Update the positions of machines in the collision worlds."""
        for machine in self.vehicles:
            motion = machine.body.motion
            if self._at_rest.get(machine) is motion:
                continue  # recorded positions remain
            for world in self._worlds.values():
                machine.stand_in(world)
            if motion.end <= self.clock.now:
                self._at_rest[machine] = motion

    def put_down(self, obstacle: Obstacle) -> None:
        """Add an obstacle until `take_up` removes it.

        Parameters
        ----------
        obstacle : Obstacle
            The obstacle.
        """
        self.placed[obstacle.name] = obstacle
        self._change()

    def take_up(self, name: str) -> None:
        """Remove an obstacle that was added.

        Parameters
        ----------
        name : str
            Name of the obstacle.
        """
        self.placed.pop(name, None)
        self._change()

    def _rules_for(self, person: str) -> frozenset[str]:
        """Return the forbidden zones and one-way gates of a person. "" stands for any person."""
        plan = self.floorplan
        zones = {zone.name for zone in plan.zones if zone.forbidden and zone.is_about(person)}
        return frozenset(zones | {gate.name for gate in plan.one_ways if gate.is_about(person)})

    def _furnish(self, world: CollisionWorld, person: str) -> CollisionWorld:
        for zone in self.floorplan.zones:
            if zone.forbidden and zone.is_about(person):
                world.place(zone.name, zone.area)
        return world

    def _set(self, there: dict[str, Obstacle]) -> None:
        """Set the active closures and update the collision worlds."""
        for world in self._worlds.values():
            for name in self.active_closures.keys() - there.keys():
                if name in {body.name for body in world.bodies}:
                    world.remove(name)
            for name in sorted(there.keys() - self.active_closures.keys()):
                one = there[name]
                world.place(name, one.footprint, one.bottom, one.top)
        self.active_closures = there

    def _report(self, names: Iterable[str], *, is_there: bool) -> None:
        """Record that these closures have become active or inactive."""
        doors = {door.name for door in self.floorplan.doors}
        for name in sorted(names):
            event: EventKind
            if name in doors:
                event = DoorClosed(door=name) if is_there else DoorOpened(door=name)
            else:
                event = ObstacleCame(obstacle=name) if is_there else ObstacleWent(obstacle=name)
            self.record(event)

    def _change(self) -> None:
        """Update the closures of the current time, and notify all people and machines."""
        timed = {} if self.closures is None else self.closures.at(self.clock.now)
        before, there = self.active_closures, timed | self.placed
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


class MachineModel(ABC):
    """Base class of machine models. The model of each kind is a frozen dataclass.

    The fields are the keys in a trial file.

    Attributes
    ----------
    category : {"robot", "vehicle"} or None
        Category of all machines of this kind, or None if it depends on the shape.
    key_schema : type or None
        Model of the keys in a trial file, if these are not the fields.
    """

    __pydantic_config__: ClassVar[ConfigDict] = ConfigDict(extra="forbid", allow_inf_nan=False)

    category: ClassVar[Category | None] = None
    """Category of all machines of this kind, or None if it depends on the shape."""

    key_schema: ClassVar[type | None] = None
    """Model of the keys in a trial file, if these are not the fields."""

    @classmethod
    def read(cls, name: str, keys: Mapping[str, Any]) -> Self:
        """Return the model of a machine in a trial file.

        Parameters
        ----------
        name : str
            Name of the machine.
        keys : mapping
            Keys in the trial file.

        Raises
        ------
        pydantic.ValidationError
            If a key is unknown or its value invalid.
        """
        return _adapter(cls).validate_python(dict(keys))  # type: ignore[no-any-return]

    @abstractmethod
    def shape(self, name: str, plan: Floorplan) -> MachineShape:
        """Return the observable properties of a machine.

        Parameters
        ----------
        name : str
            Name of the machine.
        plan : Floorplan
            The floor.
        """

    @abstractmethod
    def make(self, name: str, stage: Stage) -> Machine:
        """Return a machine. It is stationary until its `begin` is called.

        Parameters
        ----------
        name : str
            Name of the machine.
        stage : Stage
            State of the simulation.
        """

    def faults(self, plan: Floorplan, vehicles: Iterable[str]) -> Iterable[Fault]:
        """Return the problems of a machine on a floor.

        Parameters
        ----------
        plan : Floorplan
            The floor.
        vehicles : iterable of str
            Names of the vehicles in the trial.

        Returns
        -------
        iterable of Fault
            Problems, each with its key.
        """
        return ()

    def place_faults(self, name: str, plan: Floorplan) -> Iterable[Fault]:
        """Return the problems of the start and the goals of a machine on a floor.

        Parameters
        ----------
        name : str
            Name of the machine.
        plan : Floorplan
            The floor.

        Returns
        -------
        iterable of Fault
            Problems, each with its key.
        """
        return ()

    def code_faults(self, folder: CodeFolder) -> Iterable[Fault]:
        """Return the problems of custom code that the model names, without importing it.

        Parameters
        ----------
        folder : CodeFolder
            Folder of custom code.

        Returns
        -------
        iterable of Fault
            Problems with their places among the keys. By default there are none.
        """
        return ()

    def stands_at_start(self, name: str, plan: Floorplan) -> Polygon | None:
        """Return the area on the floor that the machine covers at the start.

        Parameters
        ----------
        name : str
            Name of the machine.
        plan : Floorplan
            Floor.

        Returns
        -------
        Polygon or None
            None if it covers none, which is the default.
        """
        return None

    def longest_stop(self, plan: Floorplan) -> Stop | None:
        """Return the longest stop within the limits of a machine, or None if unknown.

        Parameters
        ----------
        plan : Floorplan
            The floor.
        """
        return None

    def field_limits(self, plan: Floorplan) -> VehicleLimits | AxisLimits | None:
        """Return the limits from which the lengths of fields follow, or None if unknown.

        Parameters
        ----------
        plan : Floorplan
            The floor.
        """
        return None

    @property
    def loads(self) -> tuple[bool, ...]:
        """Load states of machines of this model: one value, or both if the load changes."""
        return (False,)


@cache
def _adapter(model: type[MachineModel]) -> TypeAdapter[Any]:
    """Return the reader of the keys of a model, which takes milliseconds to build."""
    from pydantic import TypeAdapter

    return TypeAdapter(model)


@dataclass(frozen=True)
class MachineEntry:
    """Machine of a trial.

    Parameters
    ----------
    kind : str or type
        Name of a kind, a `MachineModel`, or `package.module:Class` for a model beside the trial.
    keys : dict, optional
        Values of the fields of the model.
    """

    __repr__ = brief

    kind: str | type[MachineModel]
    keys: dict[str, Any] = field(default_factory=dict)
