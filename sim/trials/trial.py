"""Trials: who is on which floor, what the machines do, which rules hold, what is expected."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import bdi
from floorplan import Floorplan, Problem, SafeZone

from ..rules import PAPER, RuleSet
from .errors import TrialError as TrialError
from .programs import load_program

if TYPE_CHECKING:
    from ..ariac import Workload


@dataclass(frozen=True)
class Start:
    """What is waited for: a time (seconds), or something that happens.

    `part_placed` holds the fields a placed part must have (part, agv), `order_submitted` the
    order's name, `event` the kind of an event; it must happen for the `count`th time. Events
    that name a person count if that is `person`, or who waits if none is given. The `time` is None
    where something else is waited for.
    """

    time: float | None = 0.0
    part_placed: dict[str, str] | None = None
    order_submitted: str | None = None
    event: str | None = None
    count: int = 1
    person: str | None = None

    def __post_init__(self) -> None:
        waits = (self.part_placed, self.order_submitted, self.event) != (None, None, None)
        if waits and self.time == 0.0:
            object.__setattr__(self, "time", None)


@dataclass(frozen=True)
class PersonalityChange:
    """From `when` on, a person has another personality, as in `PersonEntry`."""

    when: Start
    personality: str | bdi.Program

    @property
    def personality_name(self) -> str:
        """The personality's name, as that of `PersonEntry`."""
        return _personality_name(self.personality)


@dataclass(frozen=True)
class PersonEntry:
    """One person of a trial. Figures that are None are the floorplan's.

    `personality` is a built-in name, an .asl file, "external", or a program itself. A file is read
    when the trial is run. `changes` are what it changes to, and when.
    """

    name: str
    personality: str | bdi.Program = "indifferent"
    start: Start = Start()
    at: tuple[float, float] | None = None
    beliefs: tuple[str, ...] = ()
    radius: float | None = None
    max_speed: float | None = None
    max_acceleration: float | None = None
    changes: tuple[PersonalityChange, ...] = ()
    home: tuple[float, float] | None = None

    @property
    def personality_name(self) -> str:
        """The personality's name: as it is given, or of a program what its source is called."""
        return _personality_name(self.personality)

    def home_on(self, plan: Floorplan) -> SafeZone | None:
        """Place where the person is put after a violation, and starts if there is no `at`.

        Their own `home`, else the safe zone of `plan`, else `at`.
        """
        if self.home is not None:
            return SafeZone(self.home)
        if plan.safe_zone is not None or self.at is None:
            return plan.safe_zone
        return SafeZone(self.at)


@dataclass(frozen=True)
class Job:
    """One thing for the gantry to do; `kind` says which of the other fields count.

    "move": go to `target` (x, y, rotation); "wait": stand for `seconds`; "pick_place": fetch
    `part` from the place `pick` and put it at `place`; "submit": hand in `order`.
    """

    kind: Literal["move", "wait", "pick_place", "submit"]
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    seconds: float = 0.0
    pick: str = ""
    place: str = ""
    part: str = ""
    order: str = ""


@dataclass(frozen=True)
class GantryEntry:
    """The gantry of a trial: its controller, where it starts, and its jobs.

    `controller` is a built-in name, `package.module:name`, or the controller itself: a function or
    class of one argument, the gantry, that gives a generator.
    """

    controller: str | Callable[[Any], Any] = "parked"
    at: tuple[float, float, float] | None = None
    jobs: tuple[Job, ...] = ()
    repeat: bool = False

    @property
    def controller_name(self) -> str:
        """The controller's name: as it is given, or the qualified name of a function or class."""
        if isinstance(self.controller, str):
            return self.controller
        return str(getattr(self.controller, "__qualname__", type(self.controller).__qualname__))


@dataclass(frozen=True)
class AgvMove:
    """At `time` (seconds), go to a location's name or a lane position (metres)."""

    time: float
    to: str | float


@dataclass(frozen=True)
class Trial:
    """Everything that decides a run. The same trial gives the same run, byte for byte.

    The AGVs named in `yielding` yield to people. Files are looked up from `folder`;
    `floorplan_source` is the name or file that the floorplan was read from, or empty if it came
    from no file. `workload` are the orders of an ARIAC trial; `until_submitted` ends the run as
    soon as they are all submitted, or without a workload those of the gantry's jobs. `notices` are
    what the file says that makes no difference, or may mean something else than its author thought.
    Without `own_code` a controller or a law of the user's own is refused that it, or whatever
    changes it, names.
    """

    floorplan: Floorplan
    name: str = "trial"
    duration: float = 275.0
    seed: int = 0
    rules: RuleSet = PAPER
    people: tuple[PersonEntry, ...] = ()
    gantry: GantryEntry = GantryEntry()
    agvs: dict[str, tuple[AgvMove, ...]] = field(default_factory=dict)
    yielding: frozenset[str] = frozenset()
    expect: dict[str, Any] = field(default_factory=dict)
    folder: Path = Path()
    floorplan_source: str = field(default="", compare=False)
    workload: Workload | None = None
    until_submitted: bool = False
    notices: tuple[Problem, ...] = field(default=(), compare=False)
    own_code: bool = field(default=True, compare=False)

    @classmethod
    def load(cls, source: str | Path, *, own_code: bool = True) -> Trial:
        """The built-in trial called `source`, or the one in the YAML file at `source`.

        Python of the user's own that it names (a controller, a law) has to stand beside it. It is
        read, but not imported before the trial is run; without `own_code` it is refused.
        Raises `TrialError` (or `FloorplanError`, `bdi.ProgramError` for what it names) with
        everything that is wrong, each with its place.
        """
        from .trial_file import load

        return load(source, own_code)

    @classmethod
    def parse(
        cls,
        text: str,
        *,
        file: str = "<text>",
        folder: str | Path = ".",
        own_code: bool = True,
    ) -> Trial:
        """The trial in `text`, as if it stood in `folder`; errors call it `file`.

        `own_code` is as of `load`.
        """
        from .trial_file import parse

        return parse(text, file, Path(folder), own_code)

    def to_yaml(self, folder: str | Path = ".") -> str:
        """The text of a trial file that stands in `folder`, to be read as the same trial.

        `ValueError` if its floorplan, its orders, a law or a program came from no file, or if it
        names code of the user's own that stands neither in `folder` nor above it.
        """
        from .trial_writing import to_yaml

        return to_yaml(self, Path(folder))

    def save(self, path: str | Path) -> None:
        """Write the trial into the file at `path`, from where its files are found as well."""
        from ..recordings.output import write_whole

        path = Path(path)
        write_whole(path, self.to_yaml(path.parent))

    def with_personality(self, personality: str | bdi.Program) -> Trial:
        """Return the same trial in which everybody has this personality all along.

        It is as in `PersonEntry`. `TrialError` if there is none of that name, `bdi.ProgramError`
        if there is something wrong in it.
        """
        load_program(personality, self.folder)
        people = tuple(
            replace(person, personality=personality, changes=()) for person in self.people
        )
        return replace(self, people=people)


def _personality_name(personality: str | bdi.Program) -> str:
    return personality if isinstance(personality, str) else Path(personality.source).stem
