"""Bodies and machines: their motions, planned motions, shapes, and the machine interface."""

from __future__ import annotations

import inspect
import math
from abc import ABC, abstractmethod
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, partial, wraps
from typing import Any, Literal, Protocol, TypeVar, cast, get_args

from shapely import affinity
from shapely.geometry import Polygon

from floorplan import Point, UserError, rectangle
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import brief
from navigation import Box, CollisionWorld, Cylinder, Motion, Moving, Prism, first_time
from navigation.encounter import Solid
from navigation.motion import State, Track
from navigation.walking import leg_to

from .clock import Clock, InProgress
from .custom_code import argument_fault


class Plans:
    """The motions that a body set out on. A track has only what came of them.

    A law that looks ahead also needs the motion to come.
    """

    def __init__(self, since: float, motion: Motion) -> None:
        self.changes = [since]
        """Instants (seconds) from which on it was about to do each of them."""
        self._motions = [motion]

    def add(self, t: float, motion: Motion) -> None:
        """Add `motion` as its plan from `t` (seconds) on."""
        self.changes.append(t)
        self._motions.append(motion)

    def at(self, t: float) -> Motion:
        """Return its plan from `t` (seconds) on."""
        return self._motions[max(0, bisect_right(self.changes, t) - 1)]

    def before(self, t: float) -> Motion:
        """Return its plan just before `t` (seconds)."""
        return self._motions[max(0, bisect_left(self.changes, t) - 1)]


JUMP = 1e-6
"""Minimum distance in metres between two motions for a jump."""

PERSON = "person"
"""Kind of the bodies of people. The bodies of machines have the kind of the machine."""


class Body(InProgress):
    """Person or machine with its current motion and its track.

    Parameters
    ----------
    clock : Clock
        Clock of the simulation.
    name : str
        Name of the person or machine.
    kind : str
        "person", or the kind of the machine.
    motion : Motion
        Initial motion.

    Attributes
    ----------
    motion : Motion
        Current motion.
    on_change : list of callable
        Callbacks without arguments for each new motion.
    on_jump : list of callable
        Callbacks without arguments for each motion that begins at another position.
    on_record : callable or None
        Callback for each finished part of the track, with the body and a `Motion`.
    """

    def __init__(self, clock: Clock, name: str, kind: str, motion: Motion) -> None:
        self.name = name
        self.kind = kind
        self.motion = motion
        self.on_change: list[Callable[[], None]] = []
        self.on_jump: list[Callable[[], None]] = []
        self.on_record: Callable[[Body, Motion], None] | None = None
        self.clock = clock
        self._track = Track()
        self._since = clock.now
        self._turned = clock.now
        """When it was last asked on which leg it came, seconds."""
        self._leg = (0.0, 0.0)
        """That leg, metres."""

    def __repr__(self) -> str:
        return f"<{self.kind} {self.name}>"

    @property
    def state(self) -> State:
        """Current pose and velocity."""
        return self.motion.state(self.clock.now)

    @property
    def at(self) -> tuple[float, float]:
        """Current position (x, y) in metres."""
        return self.state.at

    @property
    def leg(self) -> tuple[float, float]:
        """Straight displacement (x, y) in metres before the current time. See `leg_to`.

        It does not depend on how often the motion changes at this time.
        """
        now = self.clock.now
        if now != self._turned:
            self._leg = leg_to(self.motion, self._turned, now, self._leg)
            self._turned = now
        return self._leg

    def follow(self, motion: Motion) -> None:
        """Replace the motion from now on, and call `on_jump` (after a jump) and `on_change`.

        Parameters
        ----------
        motion : Motion
            New motion.
        """
        self.settle()
        # Settled first: what was carried out until now belongs to the old motion.
        now = self.clock.now
        before, after = self.motion.state(now).position, motion.state(now).position
        if self.kind == PERSON:
            _ = self.leg  # what leads here belongs to the old motion as well
        self.motion = motion
        if before != after and math.dist(before[:2], after[:2]) > JUMP:
            self._leg = (0.0, 0.0)
            for jumped in self.on_jump:
                jumped()
        for changed in self.on_change:
            changed()

    def settle(self) -> None:
        """Add the motion up to now to the track."""
        now = self.clock.now
        if now > self._since:
            since, self._since = self._since, now
            self._track.add(self.motion, since, now)
            if self.on_record is not None:
                self.on_record(self, self.motion.cut(since, now))

    def track(self) -> Motion:
        """Return the whole track as one motion, which can contain jumps."""
        self.settle()
        return self._track.motion() if self._track else self.motion

    def remember_plans(self) -> Plans:
        """Return a record of all motions planned from now on, including replaced parts."""
        plans = Plans(self.clock.now, self.motion)
        self.on_change.append(lambda: plans.add(self.clock.now, self.motion))
        return plans


Category = Literal["robot", "vehicle"]
"""A robot works above people's heads or in its own range, and is always monitored. A
vehicle drives on the floor, where it can block paths, and is monitored while it moves.
"""


FLAT = 1.0
"""Height in metres of solids that are compared on the floor alone."""

ROUNDING = 1e-6
"""Tolerance of top speeds, as a share and in m/s."""


@dataclass(frozen=True, kw_only=True)
class MachineShape:
    """Properties of a machine that others can observe.

    Parameters
    ----------
    name : str
        Name of the machine.
    kind : str
        Kind of machine.
    category : {"robot", "vehicle"}
        A robot is always monitored, a vehicle while it moves.
    length, width : float
        Size in metres along and across the heading, centred on the axis.
    bottom, top : float
        Heights of its ends above the floor in metres.
    top_speed : float
        Top speed in m/s.
    reach : float, optional
        Radius in metres of a circle around the axis that contains the folded arm with what it
        carries.
    mount : float, optional
        Distance in metres from the axis forward to the shoulder of the arm.
    course : tuple of (float, float), optional
        Vertices in metres of the line on which it moves, if any.
    direction : (float, float), optional
        Unit vector of its heading, if it never turns.
    outline : tuple of (float, float), optional
        Corners in metres of its footprint, from the axis along the heading, if that is not the
        rectangle.
    loaded : bool, optional
        Whether it carries a load all the time.

    Raises
    ------
    ValueError
        If the category is unknown.
    """

    __repr__ = brief

    name: str
    kind: str
    category: Category
    length: float
    width: float
    bottom: float = 0.0
    top: float
    top_speed: float
    reach: float = 0.0
    mount: float = 0.0
    course: tuple[Point, ...] = ()
    direction: Point | None = None
    outline: tuple[Point, ...] = ()
    loaded: bool = False

    def __post_init__(self) -> None:
        if self.category not in get_args(Category):
            categories = " or ".join(get_args(Category))
            raise ValueError(f"the category of a machine is {categories}, not {self.category!r}")

    @cached_property
    def box(self) -> Box:
        """Box around the axis."""
        return Box(length=self.length, width=self.width, bottom=self.bottom, top=self.top)

    @cached_property
    def chassis(self) -> Box | Prism:
        """Solid of the footprint."""
        if not self.outline:
            return self.box
        return Prism(footprint=self.outline, bottom=self.bottom, top=self.top)

    @property
    def corners(self) -> tuple[Point, ...]:
        """Corners of the footprint, in metres from the axis along the heading and to its left."""
        return self.outline or self.box.corners

    @cached_property
    def farthest(self) -> float:
        """Distance from the axis to the farthest corner of the footprint in metres."""
        return max(math.hypot(*corner) for corner in self.corners)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Smallest and largest x and y of the footprint, in metres from the axis."""
        xs, ys = zip(*self.corners, strict=True)
        return min(xs), min(ys), max(xs), max(ys)

    @cached_property
    def silhouette(self) -> tuple[Solid, ...]:
        """Solids of the footprint and the arm, both from the floor up, whatever their heights."""
        arm = (Cylinder(radius=self.reach, top=FLAT),) if self.reach > 0 else ()
        return (replace(self.chassis, bottom=0.0, top=FLAT), *arm)

    def too_fast(self, motion: Motion, now: float) -> float | None:
        """Return the first time at which a motion exceeds the top speed, or None.

        Parameters
        ----------
        motion : Motion
            Motion of the machine.
        now : float
            Begin of the check in seconds.
        """
        too_fast = Moving(self.top_speed * (1 + ROUNDING) + ROUNDING)
        return first_time(too_fast, motion, motion, now, max(now, motion.end))

    def footprint(self, at: Point, rotation: float) -> Polygon:
        """Return the covered area.

        Parameters
        ----------
        at : (float, float)
            Position of the axis in metres.
        rotation : float
            Heading in radians.
        """
        if self.outline:
            turned = affinity.rotate(
                Polygon(self.outline), rotation, origin=(0, 0), use_radians=True
            )
            return affinity.translate(turned, *at)
        direction = (math.cos(rotation), math.sin(rotation))
        return rectangle(at, direction, self.length, self.width)


TRAFFIC = "traffic"
"""The reason for which a machine waits for another machine."""

CONTACT = "contact"
"""The reason for which a machine that commands cannot lead away stands after a contact."""


def is_there(pose: Sequence[float], target: Sequence[float], within: float) -> bool:
    """Return whether a pose is at x, y, and in the rotation, but for whole turns, if any.

    `within` is the tolerance in metres and radians.
    """
    turn = math.remainder(pose[2] - target[2], math.tau) if len(target) == 3 else 0.0
    return math.dist(pose[:2], target[:2]) < within and abs(turn) < within


_Method = TypeVar("_Method", bound=Callable[..., Any])

OnCommand = Callable[[str, dict[str, Any], Callable[[], Any]], Any]
"""Carries out a command from outside, with the name of the method and its arguments."""


class Commandable(Protocol):
    """Person or machine whose methods can be commands of the trial."""

    on_command: OnCommand | None

    @property
    def name(self) -> str:
        """Name in the trial."""

    @property
    def body(self) -> Body:
        """Its body."""


def checked(method: _Method) -> _Method:
    """Raise a `UserError` for calls of a method with missing or unknown arguments."""

    @wraps(method)
    def called(one: Commandable, *values: Any, **terms: Any) -> Any:
        try:
            return method(one, *values, **terms)
        except TypeError as why:
            if fault := argument_fault(partial(method, one), terms, *values):
                raise UserError(f"{one.name}.{method.__name__}: {fault}") from why
            raise

    return cast(_Method, called)


def commands(method: _Method) -> _Method:
    """Record calls of a method from outside the simulation as commands of the trial.

    Its arguments are `checked`.
    """
    signature = inspect.signature(method)

    @wraps(method)
    def commanded(one: Commandable, *values: Any, **terms: Any) -> Any:
        if one.on_command is None or one.body.clock.inside:
            return method(one, *values, **terms)
        _, *arguments = signature.bind(one, *values, **terms).arguments.items()
        carry_out = partial(method, one, *values, **terms)
        return one.on_command(method.__name__, dict(arguments), carry_out)

    vars(commanded)["is_command"] = True
    return checked(cast(_Method, commanded))


OnContact = Literal["stop", "report"]


class Machine(InProgress, ABC):
    """Base class of machines in a running trial. Each kind of machine is a subclass.

    Attributes
    ----------
    shape : MachineShape
        Observable properties.
    body : Body
        Current motion and track.
    on_contact : {"stop", "report"}
        Whether it stops where it touches something on the floor. If not, this is only an event.
    """

    shape: MachineShape
    body: Body
    on_contact: OnContact = "stop"
    priority: int = 0
    """Priority among machines. Those with a lower one evade first."""

    on_command: OnCommand | None = None
    """Function that carries out and records commands from outside."""

    _stands_for: frozenset[str] = frozenset()

    @property
    def name(self) -> str:
        """Name in the trial, in events and in the summary."""
        return self.shape.name

    def begin(self) -> None:
        """Start to act. It is called once, at the start of the trial."""

    @property
    def planned_at(self) -> float:
        """When its present motion was planned around all on the floor (s), by default never."""
        return -math.inf

    @abstractmethod
    def hold(self, stands: bool) -> None:
        """Start or end a protective stop.

        Parameters
        ----------
        stands : bool
            True to brake and stay stationary, False to continue.
        """

    @commands
    def stand_for(self, reason: str, stands: bool) -> None:
        """Add or remove a reason for a protective stop. It lasts while there is any reason.

        Parameters
        ----------
        reason : str
            Identifier of the reason.
        stands : bool
            True to add it, False to remove it.
        """
        before = self._stands_for
        self._stands_for = before | {reason} if stands else before - {reason}
        if bool(before) != bool(self._stands_for):
            self.hold(stands)

    @property
    def loaded(self) -> bool:
        """Whether the machine carries a load."""
        return False

    def limit_speed(self, speed: float | None) -> bool:
        """Limit the top speed, or end the limit.

        Parameters
        ----------
        speed : float or None
            Top speed in m/s, or None to end the limit.

        Returns
        -------
        bool
            False if the machine cannot, which is the default. It stops instead.
        """
        return False

    @property
    def is_held(self) -> bool:
        """Whether there is a reason for a protective stop."""
        return bool(self._stands_for)

    @property
    def waits(self) -> bool:
        """Whether the machine waits for another machine."""
        return TRAFFIC in self._stands_for

    @property
    def only_waits(self) -> bool:
        """Whether the machine waits for another machine, and nothing else holds it."""
        return self._stands_for == {TRAFFIC}

    @property
    def goal(self) -> Point | None:
        """Position (x, y) in metres to which the machine is under way, if it has one."""
        return None

    @property
    def may_leave(self) -> bool:
        """Whether a vehicle that is stationary may leave, so that others can wait for that."""
        return False

    @property
    def stopping_distance(self) -> float:
        """Longest distance of a stop in metres, by default without a limit."""
        return math.inf

    def stopping(self, state: State, t: float) -> Motion | None:
        """Return the stop of the machine without moving it, or None if it is unknown.

        Parameters
        ----------
        state : State
            Initial pose and velocity.
        t : float
            Start time in seconds.
        """
        return None

    def disable(self, seconds: float) -> None:
        """Disable the machine as a penalty. Only robots are disabled.

        Parameters
        ----------
        seconds : float
            Duration in seconds.
        """

    def touched(self) -> None:
        """Handle the begin of a contact with a person, or with something on the floor."""

    def stopped_by_contact(self) -> None:
        """Handle that a contact with the floor has stopped the machine. By default it is held."""
        self.stand_for(CONTACT, True)

    def contact_gone(self) -> None:
        """Handle that nothing is there any more that it touches."""

    def floor_changed(self) -> None:
        """Handle that a machine has stopped on the floor, or that a place has opened or closed."""

    def sight_changed(self) -> None:
        """Handle the begin or end of a blackout of the machine."""

    def look_out_for(self, person: Body, top_speed: float) -> None:
        """Start to consider a person.

        Parameters
        ----------
        person : Body
            The person.
        top_speed : float
            Top speed of the person in m/s.
        """

    def foreseen(self, until: float) -> Motion:
        """Return the motion that is predictable now.

        Parameters
        ----------
        until : float
            Time in seconds. Scheduled motions that begin earlier are included.
        """
        return self.body.motion

    def sets_out(self, after: float) -> float:
        """Return the time of the next scheduled start in seconds, or infinity.

        Parameters
        ----------
        after : float
            Time in seconds. Earlier starts are ignored.
        """
        return math.inf

    def stand_in(self, world: CollisionWorld) -> None:
        """Place the footprint of a vehicle in a collision world. Robots are not added.

        Parameters
        ----------
        world : CollisionWorld
            World to update.
        """
        if self.shape.category == "vehicle":
            x, y, rotation = self.body.state.position
            footprint = self.shape.footprint((x, y), rotation)
            world.place(self.name, footprint, self.shape.bottom, self.shape.top)

    @property
    def centre(self) -> Point:
        """Position (x, y) in metres from which `zone` is measured."""
        return self.body.at

    def zone(self, top_speed: float) -> float:
        """Return the distance in metres from which the machine starts to move near a person.

        Parameters
        ----------
        top_speed : float
            Top speed of the person in m/s.
        """
        return math.hypot(self.shape.length, self.shape.width) / 2

    def close(self) -> None:
        """Finish at the end of the trial."""

    def figures(self, motion: Motion, now: float) -> dict[str, Any]:
        """Return values for the summary that concern only this machine.

        Parameters
        ----------
        motion : Motion
            Track of the whole trial.
        now : float
            Time in seconds.
        """
        return {}
