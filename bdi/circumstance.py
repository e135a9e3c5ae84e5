"""An agent's circumstance: its events, and its intentions wherever they are.

The names are those of AgentSpeak's operational semantics: E events, I running
intentions, PA and PI intentions that wait for an action or for something else.
While an atomic intention exists, no event is taken and no other intention runs.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from .intentions import Event, Intention
from .terms import Literal, Term
from .unify import Unifier, substitute_literal, unify

if TYPE_CHECKING:
    from .alarms import Alarm
    from .waiting import Wait


class PendingAction:
    """An external action on its way; `number` names it for `Agent.finish`."""

    __slots__ = ("action", "intention", "number")

    def __init__(self, number: int, action: Literal, intention: Intention) -> None:
        self.number = number
        self.action = action
        self.intention = intention


class Circumstance:
    def __init__(self) -> None:
        self.events: deque[Event] = deque()
        self.running: deque[Intention] = deque()
        self.atomic_event: Event | None = None
        self.atomic: Intention | None = None
        self.atomic_waits = False
        self.selected_event: Event | None = None
        self.selected: Intention | None = None
        self.pending_actions: dict[int, PendingAction] = {}
        self.feedback: deque[tuple[PendingAction, bool]] = deque()
        self.pending: dict[int, tuple[str, Intention]] = {}
        self.suspended_events: list[Event] = []
        self.waits: list[Wait] = []
        self.future_events: list[Alarm] = []
        self.on_end: Callable[[Intention], None] | None = None

    # ---- events

    def post(self, event: Event) -> None:
        if event.intention is not None and event.intention.atomic:
            self.atomic_event = event
        else:
            self.events.append(event)
        if self.waits:
            for wait in list(self.waits):
                wait.notice(event)

    def all_events(self) -> list[Event]:
        first = [] if self.atomic_event is None else [self.atomic_event]
        return [*first, *self.events]

    def remove_event(self, event: Event) -> None:
        if event is self.atomic_event:
            self.atomic_event = None
        else:
            self.events = deque(e for e in self.events if e is not event)
        if event.intention is not None:
            self._dropped(event.intention)

    def remove_suspended_event(self, event: Event) -> None:
        self.suspended_events = [e for e in self.suspended_events if e is not event]
        if event.intention is not None:
            self._dropped(event.intention)

    def remove_goals(self, goal: Literal, u: Unifier) -> None:
        """Takes the `+!goal` events out, those that are suspended, too."""
        for event in list(self.events):
            if event_wants(event, goal, dict(u)):
                self.remove_event(event)
        for event in list(self.suspended_events):
            if event_wants(event, goal, dict(u)):
                self.remove_suspended_event(event)

    def clear_events(self, *, only_goals: bool = False) -> None:
        for event in self.all_events():
            if event.intention is not None and (event.is_goal or not only_goals):
                self._dropped(event.intention)
        self.events = deque(e for e in self.events if only_goals and not e.is_goal)
        self.atomic_event = None

    # ---- intentions

    def add_running(self, intention: Intention) -> None:
        if intention.atomic:
            self.atomic = intention
        else:
            intention.in_line = True
            self.running.append(intention)
        if self.waits:
            self._recheck()

    def is_running(self, intention: Intention) -> bool:
        return intention is self.atomic or intention.in_line

    def remove_running(self, intention: Intention) -> bool:
        if intention is self.atomic:
            self.atomic = None
            return True
        # Most that end are not in line: there is no need to look through those that are.
        if not intention.in_line:
            return False
        intention.in_line = False
        self.running.remove(intention)
        return True

    def drop_running(self, intention: Intention) -> None:
        if self.remove_running(intention):
            self._dropped(intention)

    def select(self) -> Intention | None:
        """Takes the intention whose turn it is."""
        if self.atomic is not None:
            if self.atomic_waits:
                return None
            intention, self.atomic = self.atomic, None
            return intention
        if not self.running:
            return None
        intention = self.running.popleft()
        intention.in_line = False
        return intention

    def suspend(self, kind: str, intention: Intention, reason: Term | None = None) -> None:
        """Keeps an intention apart until something wakes it."""
        if intention.atomic:
            self.atomic = intention
            self.atomic_waits = True
        self.pending[intention.number] = (kind, intention)
        intention.reason = reason
        if self.waits:
            self._recheck()

    def take_pending(self, intention: Intention, kind: str) -> bool:
        """Takes an intention out of those kept apart, if it is there for that reason."""
        found = self.pending.get(intention.number)
        if found is None or found[0] != kind:
            return False
        self._unpend(intention)
        return True

    def _unpend(self, intention: Intention) -> bool:
        if self.pending.pop(intention.number, None) is None:
            return False
        self._release(intention)
        return True

    def _release(self, intention: Intention) -> None:
        if intention is self.atomic:
            self.atomic = None
            self.atomic_waits = False

    def drop_pending(self, intention: Intention) -> None:
        if self._unpend(intention):
            self._dropped(intention)

    def expect(self, action: PendingAction) -> None:
        """An intention waits for its external action."""
        intention = action.intention
        if intention.atomic:
            self.atomic = intention
            self.atomic_waits = True
        self.pending_actions[intention.number] = action
        intention.reason = action.action

    def take_action(self, intention: Intention) -> PendingAction | None:
        action = self.pending_actions.pop(intention.number, None)
        if action is not None:
            self._release(intention)
        return action

    def drop_action(self, intention: Intention) -> None:
        if self.take_action(intention) is not None:
            self._dropped(intention)

    def has_feedback(self) -> bool:
        return any(not action.intention.is_suspended for action, _ in self.feedback)

    def drop(self, intention: Intention) -> None:
        """Ends an intention wherever it is."""
        for event in self.all_events():
            if event.intention is intention:
                self.remove_event(event)
        for event in list(self.suspended_events):
            if event.intention is intention:
                self.remove_suspended_event(event)
        self.drop_action(intention)
        self.drop_running(intention)
        self.drop_pending(intention)

    def clear_intentions(self) -> None:
        """Ends all intentions but the selected one, and cancels what `.at` has announced."""
        for alarm in self.future_events:
            alarm.cancel()
        self.future_events.clear()
        self.atomic = None
        self.atomic_waits = False
        for intention in list(self.running):
            intention.in_line = False
            self._dropped(intention)
        self.running.clear()
        for _, intention in list(self.pending.values()):
            self._dropped(intention)
        self.pending.clear()
        for action in list(self.pending_actions.values()):
            self._dropped(action.intention)
        self.pending_actions.clear()
        for event in self.all_events():
            if event.intention is not None:
                self.remove_event(event)
        for event in list(self.suspended_events):
            if event.intention is not None:
                self.remove_suspended_event(event)

    def forget(self, intention: Intention) -> None:
        """An intention is over: tells whoever keeps account of them."""
        if self.on_end is not None:
            self.on_end(intention)

    @property
    def size(self) -> int:
        """How many intentions run, or wait for an action or something else."""
        return len(self.running) + len(self.pending) + len(self.pending_actions)

    def intentions(self) -> Iterator[Intention]:
        """All intentions, each once, in the order in which they are looked through."""
        seen: set[int] = set()
        candidates: list[Intention | None] = [
            None if self.selected_event is None else self.selected_event.intention,
            self.selected,
            *(event.intention for event in self.all_events()),
            *(event.intention for event in self.suspended_events),
            *(action.intention for action in self.pending_actions.values()),
            *(intention for _, intention in self.pending.values()),
            self.atomic,
            *self.running,
        ]
        for intention in candidates:
            if intention is not None and intention.number not in seen and intention.stack:
                seen.add(intention.number)
                yield intention

    def _dropped(self, intention: Intention) -> None:
        if intention.wait is not None:
            intention.wait.cancel()
        self.forget(intention)
        if self.waits:
            self._recheck()

    def _recheck(self) -> None:
        for wait in list(self.waits):
            wait.notice(None)


def event_wants(event: Event, goal: Literal, u: Unifier) -> bool:
    """Whether an event is `+!goal`; binds what that takes in `u`."""
    if event.sort != "+!":
        return False
    literal = event.literal
    intention = event.intention
    if intention is not None and intention.stack:
        literal = substitute_literal(literal, intention.top.u)
    attempt = dict(u)
    if unify(goal, literal, attempt):
        u.update(attempt)
        return True
    return False
