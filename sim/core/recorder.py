"""Scene and record of a run: initial state, events, and the motions carried out.

Both are handed on at once, so that a run that is broken off leaves a whole record behind.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import Any

from floorplan import Floorplan, Obstacle
from navigation import Motion

from .body import PERSON, Body, MachineShape
from .entries import Pose
from .events import EventKind, has_form
from .rules import RuleSet


@dataclass(frozen=True)
class Figure:
    """A person as others see them: a name, a personality, and a size (metres).

    `personality` is as the trial gives it: a built-in name, or the path of an .asl file.
    """

    name: str
    _: KW_ONLY
    personality: str
    radius: float
    height: float


@dataclass(frozen=True, kw_only=True)
class Scene:
    """All that stays the same during a run, but is needed to draw or to judge it.

    `starts` has the pose of every body at the beginning, people first, then `machines`. Obstacles
    in `passing` come and go: events say when. `controller` is the name of the gantry's, empty where
    there is no gantry or it is not known.
    """

    trial: str
    seed: int
    floorplan: Floorplan
    rules: RuleSet
    people: tuple[Figure, ...]
    starts: dict[str, Pose]
    machines: tuple[MachineShape, ...] = ()
    passing: tuple[Obstacle, ...] = ()
    controller: str = ""

    def kind(self, body: str) -> str:
        """Return the kind of the body named `body`; `KeyError` if there is none."""
        if body not in self.starts:
            raise KeyError(f"no body is called {body!r} (there are: {', '.join(self.starts)})")
        if any(person.name == body for person in self.people):
            return PERSON
        return self.machine(body).kind

    def machine(self, name: str) -> MachineShape:
        """Return the machine `name`; `KeyError` if there is none."""
        for machine in self.machines:
            if machine.name == name:
                return machine
        raise KeyError(f"no machine is called {name!r}")


DECIMALS = 9
"""Figures of events and summaries are rounded to this many decimals."""

Event = dict[str, Any]
"""`t` (seconds), `kind`, and what belongs to the kind."""

Record = Callable[[EventKind], None]
"""Records that something happens now."""

Thought = dict[str, Any]
"""Changes that one thought has made in a mind.

`t` (seconds) and `person`; `steps`, in order, [kind, text] of kind "percept", "plan" (with a third
item, the place in the program), "action" or "warning"; `believes` and `forgets`, literals;
`intends`, if that has changed: for each intention its `stack` of triggers, the one at work last,
and the step it is `at`. All but `t` and `person` may be left out.
"""


class Listener:
    """Is notified of every event and every finished motion; does nothing with them.

    If it `wants_thoughts`, also of what goes on in people's minds, which takes time to find out.
    """

    wants_thoughts = False

    def begin(self, scene: Scene) -> None:
        """Take note that everybody is in place: the run begins."""

    def event(self, event: Event) -> None:
        """Take note of an event."""

    def motion(self, body: Body, motion: Motion) -> None:
        """Take note of a motion that a body has carried out."""

    def thought(self, thought: Thought) -> None:
        """Take note of a person's thought."""


class Listeners(Listener):
    """Hands on to several listeners, in their order."""

    def __init__(self, *listeners: Listener) -> None:
        self._listeners = listeners
        self.wants_thoughts = any(listener.wants_thoughts for listener in listeners)
        self.wants_motions = any(type(one).motion is not Listener.motion for one in listeners)
        """Whether any of them does something with motions."""

    def begin(self, scene: Scene) -> None:
        """Notify each of them that everybody is in place: the run begins."""
        for listener in self._listeners:
            listener.begin(scene)

    def event(self, event: Event) -> None:
        """Notify each of them of an event."""
        for listener in self._listeners:
            listener.event(event)

    def motion(self, body: Body, motion: Motion) -> None:
        """Notify each of them of a motion that a body has carried out."""
        for listener in self._listeners:
            listener.motion(body, motion)

    def thought(self, thought: Thought) -> None:
        """Notify those that want thoughts of one."""
        for listener in self._listeners:
            if listener.wants_thoughts:
                listener.thought(thought)


def recording_to(listener: Listener, now: Callable[[], float]) -> Record:
    """Return a `Record` that stamps events with the time and hands them to `listener`."""

    def record(event: EventKind) -> None:
        recorded: Event = {"t": rounded(now()), "kind": event.kind}
        for name, value in event.fields.items():
            recorded[name] = value if value.__class__ is str else rounded(value)
        if event._own:
            _require_forms(event, recorded)
        listener.event(recorded)

    return record


def _require_forms(event: EventKind, recorded: Event) -> None:
    """`ValueError` if a field of an event of the user's own is not what its class declares."""
    for name, form in event.forms.items():
        if name in recorded and not has_form(recorded[name], form):
            raise ValueError(f"{name} of {event.kind} is a {form}, not {recorded[name]!r}"[:200])


_AS_IT_IS = frozenset((str, int, bool, type(None)))
"""Types of which nothing is rounded."""


def rounded(value: Any) -> Any:
    """Return the same data with its floats rounded to `DECIMALS`, and no negative zero."""
    if isinstance(value, float):
        short = round(value, DECIMALS) + 0.0
        # Thousands of events name the same places: the same number need be there but once.
        return value if value == short != 0.0 else short
    if value.__class__ in _AS_IT_IS:
        return value
    if isinstance(value, dict):
        return {key: rounded(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        if len(value) == 2:  # a point, as most are: a list of just that size
            return [rounded(value[0]), rounded(value[1])]
        return list(map(rounded, value))
    return value
