"""Scene and record of a run: initial state, events and finished motions.

Listeners are notified immediately, so that the record of an interrupted run is complete.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, field
from typing import Any

from floorplan import Floorplan, Obstacle, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.fields import brief
from navigation import Motion, Shapes

from .body import PERSON, Body, MachineShape
from .entries import Command, Pose
from .events import EventKind, has_form
from .fields import MachineFields
from .rules import RuleSet


@dataclass(frozen=True)
class Figure:
    """Observable properties of a person. Lengths are in metres.

    `personality` is a built-in name or the path of an .asl file.
    """

    name: str
    _: KW_ONLY
    personality: str
    radius: float
    height: float


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Constant facts of a run that are needed to draw or evaluate it.

    `starts` contains the initial pose of every body, people first. Obstacles in `passing` appear
    and disappear by events. `controller` is the name of the gantry's controller, or empty. `fields`
    has the protective fields by the name of the machine.
    """

    __repr__ = brief

    trial: str
    seed: int
    floorplan: Floorplan
    rules: RuleSet
    people: tuple[Figure, ...]
    starts: dict[str, Pose]
    machines: tuple[MachineShape, ...] = ()
    passing: tuple[Obstacle, ...] = ()
    controller: str = ""
    fields: Mapping[str, MachineFields] = field(default_factory=dict)

    def kind(self, body: str) -> str:
        """Return the kind of a body. Raises `KeyError` if there is none of that name."""
        if body not in self.starts:
            raise KeyError(f"no body is called {body!r} (there are: {', '.join(self.starts)})")
        if any(person.name == body for person in self.people):
            return PERSON
        return self.machine(body).kind

    def shapes(self, person: str, machine: str) -> Shapes | None:
        """Return the solids between which the rules measure, or None between centres.

        Raises `KeyError` if there is no such person or machine.
        """
        radii = {one.name: one.radius for one in self.people}
        return self.rules.shapes_of(self.machine(machine), radii[person])

    def machine(self, name: str) -> MachineShape:
        """Return a machine. Raises `KeyError` if there is none of that name."""
        for machine in self.machines:
            if machine.name == name:
                return machine
        raise KeyError(f"no machine is called {name!r}")


DECIMALS = 9
"""Number of decimals of values in events and summaries."""

Event = dict[str, Any]
"""Time `t` (s), `kind`, and the fields of that kind."""

Record = Callable[[EventKind], None]
"""Function that records an event at the current time."""

Thought = dict[str, Any]
"""Changes made by one reasoning step of a person.

The keys are `t` (s), `person`, and optionally the following. `steps` are [kind, text] in order, of
kind "percept", "plan" (with the location in the program as third item), "action" or "warning".
`believes` and `forgets` are literals. `intends` has, for each intention, its `stack` of triggers,
the active one last, and the step it is `at`.
"""


class Listener:
    """Base class of listeners, which are notified of events and finished motions.

    Attributes
    ----------
    wants_thoughts : bool
        Whether the listener is also notified of thoughts. Collecting them takes time.
    """

    wants_thoughts = False

    def begin(self, scene: Scene) -> None:
        """Handle the begin of the run.

        Parameters
        ----------
        scene : Scene
            Initial state.
        """

    def event(self, event: Event) -> None:
        """Handle an event.

        Parameters
        ----------
        event : dict
            Event as in recordings, with time `t` in seconds and `kind`.
        """

    def command(self, command: Command) -> None:
        """Handle a command that takes effect.

        Parameters
        ----------
        command : Command
            The command, with its exact time.
        """

    def motion(self, body: Body, motion: Motion) -> None:
        """Handle a finished motion.

        Parameters
        ----------
        body : Body
            Person or machine.
        motion : Motion
            Motion that was carried out.
        """

    def thought(self, thought: Thought) -> None:
        """Handle a thought of a person.

        Parameters
        ----------
        thought : dict
            Changes made by one reasoning step, as in recordings.
        """


class Listeners(Listener):
    """Group of listeners, which are notified in order."""

    def __init__(self, *listeners: Listener) -> None:
        self._listeners = listeners
        self.wants_thoughts = any(listener.wants_thoughts for listener in listeners)
        self.wants_motions = any(type(one).motion is not Listener.motion for one in listeners)
        """Whether any of them does something with motions."""

    def begin(self, scene: Scene) -> None:
        """Notify each listener of the begin of the run."""
        for listener in self._listeners:
            listener.begin(scene)

    def event(self, event: Event) -> None:
        """Notify each listener of an event."""
        for listener in self._listeners:
            listener.event(event)

    def command(self, command: Command) -> None:
        """Notify each listener of a command."""
        for listener in self._listeners:
            listener.command(command)

    def motion(self, body: Body, motion: Motion) -> None:
        """Notify each listener of a finished motion."""
        for listener in self._listeners:
            listener.motion(body, motion)

    def thought(self, thought: Thought) -> None:
        """Notify the listeners that want thoughts."""
        for listener in self._listeners:
            if listener.wants_thoughts:
                listener.thought(thought)


def recording_to(listener: Listener, now: Callable[[], float]) -> Record:
    """Return a function that adds the time to events and passes them to `listener`."""

    def record(event: EventKind) -> None:
        if not isinstance(event, EventKind):
            raise UserError(f"record(event) must be an event, as a sim.EventKind, not {event!r}")
        recorded: Event = {"t": rounded(now()), "kind": event.kind}
        for name, value in event.fields.items():
            recorded[name] = value if value.__class__ is str else rounded(value)
        if event._own:
            _require_forms(event, recorded)
        listener.event(recorded)

    return record


def _require_forms(event: EventKind, recorded: Event) -> None:
    """Raise `ValueError` if a field of a custom event does not match its declaration."""
    for name, form in event.forms.items():
        if name in recorded and not has_form(recorded[name], form):
            raise ValueError(f"{name} of {event.kind} is a {form}, not {recorded[name]!r}"[:200])


_AS_IT_IS = frozenset((str, int, bool, type(None)))
"""Types of which nothing is rounded."""


def rounded(value: Any) -> Any:
    """Return the same data with its floats rounded to `DECIMALS`, and no negative zero."""
    if value.__class__ in _AS_IT_IS:
        return value
    if isinstance(value, float):
        short = round(value, DECIMALS) + 0.0
        # Thousands of events name the same places: the same number need be there but once.
        return value if value == short != 0.0 else short
    if isinstance(value, dict):
        return {key: rounded(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        if len(value) == 2:  # a point, as most are: a list of just that size
            return [rounded(value[0]), rounded(value[1])]
        return list(map(rounded, value))
    return value
