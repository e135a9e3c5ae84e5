"""Scenarios: floor, people, machines, orders, rules, and expectations of a trial."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import KW_ONLY, field, replace
from functools import lru_cache
from itertools import accumulate, count, islice
from pathlib import Path
from random import Random
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, WrapValidator, model_validator
from typing_extensions import Self

import bdi
from floorplan import Floorplan, InputError, Point, Problem, SafeZone, UserError
from floorplan.checks import starting_fault
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import (
    Constrained,
    Expected,
    Fits,
    Flag,
    Keyed,
    NotNegative,
    Number,
    Positive,
    brief,
    whole,
)
from floorplan.files.forms import Written
from floorplan.files.problems import suggestion
from navigation import Motion
from navigation.catalog import PlannerChoice

from .body import OnContact
from .custom_code import CodeFolder
from .entries import (
    ALL_ROUND,
    AS_USUAL,
    AT_ONCE,
    UNSIGNED,
    Blackout,
    Command,
    Drop,
    MannersEntry,
    NoticingEntry,
    OrderedWork,
    Place,
    Pose,
    RecordedTrack,
    SignOff,
    Spread,
    Start,
    seed_of,
)
from .fields import MachineFields
from .rules import PAPER, RuleSet
from .schedule import (
    Break,
    Delay,
    DoorTimes,
    Drawn,
    Length,
    Shift,
    TimedObstacle,
    WorkList,
    WorkTask,
)
from .stage import MachineEntry

RECORDED = "recorded"
"""Personality of recorded people in reports."""

ANYWHERE = "anywhere"
"""Place of people who start at a random free position."""

USUAL_PLANNER = PlannerChoice()
"""Default path planner of people."""


ASSUMED = (
    "floorplan",
    "rules",
    "machines",
    "radius",
    "max_speed",
    "field_of_view",
    "reaction_time",
    "personality",
    "work",
    "recorded",
)
"""Assumed values of a trial, whose sources a report names."""

IN_FRONT = 0.05
"""Distance in metres between a door and a person who enters by it."""


class TrialError(InputError):
    """Error of a trial that cannot be run."""


NAME = r"[^\W\d_][\w-]*"
"""Regular expression of the names of people, machines and work lists."""

Name = Annotated[str, Constrained(pattern=f"^{NAME}$")]

Personality = Annotated[str | bdi.Program, Written(str)]
"""Built-in name, .asl file, "external", or a program."""

Planner = Annotated[PlannerChoice, Written(Any), AfterValidator(PlannerChoice.of)]
"""Planner. A file contains its name, or `{name: RRTConnect, range: 1.0}`."""


@dataclass(frozen=True)
class PersonalityChange(Keyed):
    """Change of a person's personality.

    Parameters
    ----------
    when : Start
        Condition for the change.
    personality : str or bdi.Program
        New personality, as in `PersonEntry`.
    """

    when: Start
    personality: Personality

    @property
    def personality_name(self) -> str:
        """Name of the personality. For a program it is derived from its source."""
        return _personality_name(self.personality)


@dataclass(frozen=True)
class Source(Keyed):
    """Source of a person who enters the floor during the trial.

    The times between the people of a stream are exponentially distributed and depend on the random
    seed of the trial.

    Parameters
    ----------
    at : str or (float, float)
        Name of a station or door, or position in metres.
    rate : float
        Mean number of people per second.
    start : float, optional
        Begin of the stream in seconds.
    stream : str, optional
        Name of the stream.
    number : int, optional
        Number of the person in the stream, counted from 1.
    """

    at: Place
    rate: Positive
    _: KW_ONLY
    start: NotNegative = 0.0
    stream: str = ""
    number: Annotated[int, whole(1)] = 1

    def time(self, seed: int) -> float:
        """Return the time of entry in seconds.

        Parameters
        ----------
        seed : int
            Random seed of the trial.
        """
        times, others = _stream(seed, self.stream, self.rate)
        times.extend(islice(others, max(self.number - len(times), 0)))
        return self.start + times[self.number - 1]


@lru_cache
def _stream(seed: int, name: str, rate: float) -> tuple[list[float], Iterator[float]]:
    """Return the cached entry times (s) of a stream, and an iterator of later ones."""
    random = Random(seed_of(seed, f"source {name}"))
    return [], accumulate(random.expovariate(rate) for _ in count())


def _as_list(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


_TASKS = Expected("a list of tasks", list, tuple)


@dataclass(frozen=True)
class PersonEntry(Keyed):
    """Person of a trial. Values that are None are those of the floorplan or the trial.

    Parameters
    ----------
    name : str
        Name of the person.
    personality : str or bdi.Program, optional
        Built-in name, .asl file, "external", or a program. A file is read when the trial is run.
    start : Start, optional
        Condition for the start.
    at : str or (float, float), optional
        Start: position in metres, name of a station or door, or "anywhere" for a random free
        position.
    beliefs : tuple of str, optional
        Further initial beliefs.
    radius : float, optional
        Radius in metres.
    max_speed : float or distribution, optional
        Top speed in m/s.
    max_acceleration : float, optional
        Maximum acceleration in m/s².
    changes : tuple of PersonalityChange, optional
        Changes of personality.
    home : str or (float, float), optional
        Place where the person is put after a violation.
    manners : MannersEntry, optional
        Behaviour among other people.
    planner : PlannerChoice, optional
        Path planner.
    actions : str, optional
        Module beside the trial with internal actions. They precede those of the trial.
    work : tuple of str, optional
        Names of the work lists from which the person takes tasks.
    schedule : tuple of WorkTask, optional
        Tasks of this person alone.
    breaks : tuple of Break, optional
        Breaks of this person.
    shifts : tuple of Shift, optional
        Time spans in which tasks are offered. The default is the whole trial.
    recorded : RecordedTrack or Motion, optional
        Measured trajectory to follow instead of a program. t = 0 of a `Motion` is the start.
    source : Source, optional
        Place where the person enters the floor and starts.
    sink : str or (float, float), optional
        Place where the person leaves the floor on arrival.
    group : str, optional
        Name of a group. Its members walk with the first one.
    noticing : NoticingEntry, optional
        Perception of machines.
    agent_lag : float or (float, float), optional
        Delay in seconds between percept and reasoning: fixed, or the range of a uniform
        distribution.
    """

    name: Name
    _: KW_ONLY
    personality: Personality = "indifferent"
    start: Start = AT_ONCE
    at: Place | None = None
    beliefs: tuple[str, ...] = ()
    radius: Positive | None = None
    max_speed: Drawn | None = None
    max_acceleration: Positive | None = None
    changes: tuple[PersonalityChange, ...] = ()
    home: Place | None = None
    manners: MannersEntry = AS_USUAL
    planner: Planner | None = None
    actions: str | None = None
    work: Annotated[
        tuple[str, ...],
        BeforeValidator(_as_list),
        Expected("the name of a work list, or a list of such names", list, tuple, str),
    ] = ()
    schedule: Annotated[tuple[WorkTask, ...], _TASKS] = ()
    breaks: Annotated[tuple[Break, ...], _TASKS] = ()
    shifts: tuple[Shift, ...] = ()
    recorded: Annotated[RecordedTrack | Motion | None, Written(RecordedTrack | None)] = None
    source: Source | None = None
    sink: Place | None = None
    group: Name | None = None
    noticing: NoticingEntry = ALL_ROUND
    agent_lag: Spread | None = None

    @property
    def works(self) -> bool:
        """Whether the person may have tasks or breaks."""
        return bool(self.work or self.schedule or self.breaks)

    @property
    def personality_name(self) -> str:
        """Name of the personality. For a program it is derived from its source."""
        if self.recorded is not None:
            return RECORDED
        return _personality_name(self.personality)

    @property
    def anywhere(self) -> bool:
        """Whether the person starts at a random free position."""
        return isinstance(self.at, str) and self.at == ANYWHERE

    def place_on(self, plan: Floorplan) -> Point | None:
        """Return the start position (x, y) in metres, or None if there is none or it is random.

        Parameters
        ----------
        plan : Floorplan
            The floor.
        """
        if self.at is None or self.anywhere:
            return None
        return spot(plan, self.at, self.radius)

    def home_on(self, plan: Floorplan) -> SafeZone | None:
        """Return the place where the person is put after a violation.

        This is `home`, the safe zone of the floor, the start, or the entrance, whichever is defined
        first. It is also the start if `at` is not given.

        Parameters
        ----------
        plan : Floorplan
            The floor.

        Returns
        -------
        SafeZone or None
            The place, or None if it is random or unknown on this floor.
        """
        if self.home is not None:
            place = spot(plan, self.home, self.radius)
        elif plan.safe_zone is not None:
            return plan.safe_zone
        else:
            place = self.place_on(plan) if self.source is None else self.entrance_on(plan)
        return None if place is None else SafeZone(place)

    def entrance_on(self, plan: Floorplan) -> Point | None:
        """Return the position (x, y) in metres of the source, or None.

        Parameters
        ----------
        plan : Floorplan
            The floor.
        """
        return None if self.source is None else spot(plan, self.source.at, self.radius)

    def sink_on(self, plan: Floorplan) -> Point | None:
        """Return the position (x, y) in metres of the sink, or None.

        Parameters
        ----------
        plan : Floorplan
            The floor.
        """
        return None if self.sink is None else spot(plan, self.sink, self.radius)


@dataclass(frozen=True)
class Job:
    """Job of the gantry. Use `target` for "move", `seconds` for "wait", `order` for "submit".

    A "pick_place" job uses `pick`, `place` and `part`.

    Parameters
    ----------
    kind : {"move", "wait", "pick_place", "submit"}
        Kind of job.
    target : (float, float, float), optional
        Pose: x and y in metres and rotation in radians.
    seconds : float, optional
        Duration in seconds.
    pick, place : str, optional
        Names of the places where the part is picked up and put down.
    part : str, optional
        Type of the part.
    order : str, optional
        Name of the order.
    """

    __repr__ = brief

    kind: Literal["move", "wait", "pick_place", "submit"]
    _: KW_ONLY
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    seconds: float = 0.0
    pick: str = ""
    place: str = ""
    part: str = ""
    order: str = ""

    def written(self) -> dict[str, Any]:
        """Return the keys of the job in a file, as in `JobKeys`."""
        if self.kind == "move":
            return {"move": self.target}
        if self.kind == "wait":
            return {"wait": self.seconds}
        if self.kind == "submit":
            return {"submit": self.order}
        return {"pick": self.pick, "place": self.place, "part": self.part}


@dataclass(frozen=True, kw_only=True)
class JobKeys(Keyed):
    """Keys of a job in a file."""

    move: Pose | None = None
    wait: Positive | None = None
    pick: str | None = None
    place: str | None = None
    part: str = "part"
    submit: str | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        keys = {name for name, value in vars(self).items() if value is not None} - {"part"}
        if keys not in ({"move"}, {"wait"}, {"pick", "place"}, {"submit"}):
            raise UserError("a job is one of move, wait, pick with place, or submit")
        return self

    def value(self) -> Job:
        """Return the job."""
        if self.move is not None:
            return Job("move", target=self.move)
        if self.wait is not None:
            return Job("wait", seconds=self.wait)
        if self.submit is not None:
            return Job("submit", order=self.submit)
        return Job("pick_place", pick=self.pick or "", place=self.place or "", part=self.part)


_WrittenJob = Annotated[JobKeys, AfterValidator(JobKeys.value)]


def _or_callable(value: Any, read: Callable[[Any], str]) -> Any:
    return value if callable(value) else read(value)


Controller = Annotated[
    str | Callable[[Any], Any], Written(Annotated[str, WrapValidator(_or_callable)])
]
"""Controller of a machine: a built-in name, `package.module:name`, or a function or class."""


def controller_name(controller: str | Callable[[Any], Any]) -> str:
    """Return the name of a controller, or the qualified name of a function or class."""
    if isinstance(controller, str):
        return controller
    return str(getattr(controller, "__qualname__", type(controller).__qualname__))


@dataclass(frozen=True)
class GantryEntry(Keyed):
    """Gantry of a trial.

    Parameters
    ----------
    controller : str or callable, optional
        Built-in name, `package.module:name`, or a function or class that takes a `GantryRobot` and
        returns a generator, or a target (x, y in metres, and share of the speed) if it has a rate.
    rate : float, optional
        Rate in Hz at which a function or class is called for a target.
    at : (float, float, float), optional
        Start pose: x and y in metres and rotation in radians. Defaults to that of the floorplan.
    jobs : tuple of Job, optional
        Jobs in order.
    repeat : bool, optional
        Whether the jobs are repeated until the end.
    drops : tuple of Drop, optional
        Parts that the gripper drops.
    on_contact : {"stop", "report"}, optional
        Whether it stops at a contact with something on the floor. If not, this is only an event.
    """

    controller: Controller = "parked"
    _: KW_ONLY
    rate: Positive | None = None
    at: Pose | None = None
    jobs: tuple[Annotated[Job, Written(_WrittenJob)], ...] = ()
    repeat: Flag = False
    drops: tuple[Drop, ...] = ()
    on_contact: OnContact = "stop"

    @property
    def controller_name(self) -> str:
        """Name of the controller, or the qualified name of the function or class."""
        return controller_name(self.controller)


@dataclass(frozen=True)
class AgvMove(Keyed):
    """Move of an AGV to a location or lane position.

    Parameters
    ----------
    time : float
        Time in seconds.
    to : str or float
        Name of a location, or position along the lane in metres.
    every : float, optional
        Period in seconds after which the move is repeated.
    """

    time: NotNegative
    to: str | Number
    every: Positive | None = None


LARGEST_SEED = 2**63 - 1
"""Largest seed. Tables and recordings store 63 bits."""


def _seed_fault(seed: int) -> str:
    if isinstance(seed, int) and 0 <= seed <= LARGEST_SEED:
        return ""
    value = "a larger one" if isinstance(seed, int) and seed > 0 else repr(seed)
    return f"must be a whole number from 0 to 2**63 - 1, not {value}"


Seed = Annotated[int, whole(0, LARGEST_SEED, _seed_fault)]
"""Random seed of a trial."""


def _assumed_fault(name: str) -> str:
    if name in ASSUMED:
        return ""
    return f"{name!r} is not an assumed value; {suggestion(name, ASSUMED)}"


@dataclass(frozen=True)
class Scenario:
    """Values that define a run. See `Trial` for their meaning."""

    floorplan: Floorplan
    _: KW_ONLY
    name: str = "trial"
    duration: Length = 275.0
    seed: Seed = 0
    rules: RuleSet = PAPER
    planner: Planner = USUAL_PLANNER
    people: tuple[PersonEntry, ...] = ()
    gantry: GantryEntry = GantryEntry()
    agvs: dict[str, tuple[AgvMove, ...]] = field(default_factory=dict)
    yielding: frozenset[str] = frozenset()
    steering: str | None = None
    actions: str | None = None
    machines: dict[str, MachineEntry] = field(default_factory=dict)
    fields: dict[str, MachineFields] = field(default_factory=dict)
    expect: dict[str, Any] = field(default_factory=dict)
    folder: Path = Path()
    floorplan_source: str = field(default="", compare=False)
    workload: OrderedWork | None = None
    until_submitted: bool = False
    notices: tuple[Problem, ...] = field(default=(), compare=False)
    own_code: bool = field(default=True, compare=False)
    work: dict[Name, WorkList] = field(default_factory=dict)
    doors: dict[str, DoorTimes] = field(default_factory=dict)
    obstacles: tuple[TimedObstacle, ...] = ()
    blackouts: tuple[Blackout, ...] = ()
    commands: tuple[Command, ...] = ()
    sources: dict[Annotated[str, Fits(_assumed_fault)], str] = field(default_factory=dict)
    counterfactual: Literal["without machines", "without people"] | None = None
    warm_up: Delay = 0.0
    sign_off: SignOff = UNSIGNED
    traffic: Flag = True

    @property
    def code_folder(self) -> CodeFolder:
        """Folder of its custom code."""
        return CodeFolder(self.folder, self.own_code)

    def with_people(self, change: Callable[[PersonEntry], PersonEntry]) -> Self:
        """Return this trial with all people changed.

        Parameters
        ----------
        change : callable
            Function that takes a `PersonEntry` and returns the changed one.
        """
        return replace(self, people=tuple(map(change, self.people)))

    def leader(self, person: PersonEntry) -> PersonEntry | None:
        """Return the first person of a person's group, or None if there is no other.

        Parameters
        ----------
        person : PersonEntry
            The person.
        """
        if person.group is None:
            return None
        first = next(one for one in self.people if one.group == person.group)
        return None if first.name == person.name else first

    def led_by(self, person: PersonEntry) -> tuple[PersonEntry, ...]:
        """Return the other members of a group if the person is its first, otherwise none.

        Parameters
        ----------
        person : PersonEntry
            The person.
        """
        if person.group is None or self.leader(person) is not None:
            return ()
        return tuple(one for one in self.people if one.group == person.group)[1:]

    @property
    def has_traffic(self) -> bool:
        """Whether people enter or leave the floor."""
        return any(
            person.source
            or person.sink
            or (isinstance(person.recorded, RecordedTrack) and person.recorded.while_tracked)
            for person in self.people
        )

    @property
    def every_blackout(self) -> tuple[Blackout, ...]:
        """Blackouts of the trial and of its orders."""
        return self.blackouts + (() if self.workload is None else self.workload.blackouts)

    @property
    def has_work(self) -> bool:
        """Whether there are tasks for people."""
        return bool(self.work) or any(person.works for person in self.people)


def spot(plan: Floorplan, at: Point | str, radius: float | None = None) -> Point | None:
    """Return a position given by coordinates or by the name of a station or door, or None.

    For a door it is the side where a person of the radius (m) can stand, preferably in the door.
    """
    if not isinstance(at, str):
        return float(at[0]), float(at[1])
    door = next((one for one in plan.doors if one.name == at), None)
    if door is None:
        return next((one.position for one in plan.stations if one.name == at), None)
    (ax, ay), (bx, by) = door.ends
    x, y, width = (ax + bx) / 2, (ay + by) / 2, math.dist(*door.ends)
    away = (plan.human.radius if radius is None else radius) + door.thickness / 2 + IN_FRONT
    across = (away * (ay - by) / width, away * (bx - ax) / width)
    places = [(x + k * across[0], y + k * across[1]) for k in (0, 1, -1)]
    return next((one for one in places if not starting_fault(plan, one, radius)), places[0])


def _personality_name(personality: str | bdi.Program) -> str:
    return personality if isinstance(personality, str) else Path(personality.source).stem
