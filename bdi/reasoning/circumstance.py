"""The circumstance of an agent: events, intentions and timers.

After the operational semantics of AgentSpeak (Bordini, Hübner and Wooldridge, "Programming
Multi-Agent Systems in AgentSpeak using Jason", 2007, ch. 10): events E, running intentions I,
intentions pending for an action PA, and pending for other reasons PI. An atomic intention stops
events and other intentions.
"""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import count
from typing import TypeAlias

from ..language.substitution import Unifier, with_more_annots
from ..language.terms import Literal, Term
from .intentions import Event, Intention, Wait
from .plans import PlanLibrary


class Timer:
    """Task that runs at a time unless it is cancelled earlier."""

    __slots__ = ("cancelled", "task")

    def __init__(self, task: Callable[[], None]) -> None:
        self.task = task
        self.cancelled = False

    def cancel(self) -> None:
        """Prevent the task from running."""
        self.cancelled = True


class TimerQueue:
    """Timers in order of time (ns), then of creation."""

    def __init__(self) -> None:
        self.heap: list[tuple[int, int, Timer]] = []
        self._order = count()

    def set(self, clock: int, task: Callable[[], None]) -> Timer:
        """Schedule `task` at `clock` (ns)."""
        timer = Timer(task)
        heapq.heappush(self.heap, (clock, next(self._order), timer))
        return timer

    @property
    def next(self) -> int | None:
        """Time of the next timer (ns), or None."""
        heap = self.heap
        while heap and heap[0][2].cancelled:
            heapq.heappop(heap)
        return heap[0][0] if heap else None

    def is_due(self, clock: int) -> bool:
        """Return whether a timer is due at `clock` (ns)."""
        following = self.next
        return following is not None and following <= clock

    def run_due(self, clock: int) -> None:
        """Run the tasks that are due at `clock` (ns)."""
        while self.is_due(clock):
            heapq.heappop(self.heap)[2].task()

    def clear(self) -> None:
        """Cancel all timers."""
        self.heap.clear()


class Pending:
    """Type of `PENDING`."""

    def __repr__(self) -> str:
        return "bdi.PENDING"

    def __reduce__(self) -> str:
        return "PENDING"


PENDING = Pending()
"""Return value of `act` for an action whose outcome `Agent.finish` will report."""


@dataclass(frozen=True)
class Refused:
    """Return value of `act` for an action that failed.

    Parameters
    ----------
    reason : str
        Reason, which appears in a warning.
    """

    reason: str

    def __bool__(self) -> bool:
        return False


Perform: TypeAlias = Callable[[Literal], bool | Refused | Pending]


class PendingAction:
    """External action without an outcome yet. `number` identifies it for `Agent.finish`."""

    __slots__ = ("action", "intention", "number")

    def __init__(self, number: int, action: Literal, intention: Intention) -> None:
        self.number = number
        self.action = action
        self.intention = intention


class Circumstance:
    """Events and intentions of one agent.

    Attributes
    ----------
    events
        Events to be handled, in order.
    atomic_event
        Event for which an atomic intention waits. It precedes the others.
    suspended_events
        Events deferred by `.suspend`.
    future_events
        Timers of the events scheduled by `.at`.
    running
        Intentions that run in turns.
    atomic
        Atomic intention, if any.
    atomic_waits
        True while that intention is pending.
    selected_event, selected
        Event and intention of the current reasoning cycle.
    pending_actions
        External action of each intention that waits for one, by the number of the intention.
    feedback
        Outcomes of actions in order of arrival.
    pending
        Intentions that wait for anything else and their reason, by number.
    waits
        Waits that events and changes may end.
    on_end
        Callback for each intention that has ended.
    states
        Recorder of goal states, if plans use them.
    has_conditions
        True if intentions may have plans that end by a condition.
    """

    def __init__(self) -> None:
        self.events: deque[Event] = deque()
        self.atomic_event: Event | None = None
        self.suspended_events: list[Event] = []
        self.future_events: list[Timer] = []
        self.running: deque[Intention] = deque()
        self.atomic: Intention | None = None
        self.atomic_waits = False
        self.selected_event: Event | None = None
        self.selected: Intention | None = None
        self.pending_actions: dict[int, PendingAction] = {}
        self.feedback: deque[tuple[PendingAction, bool | Refused]] = deque()
        self.pending: dict[int, tuple[str, Intention]] = {}
        self.waits: list[Wait] = []
        self.on_end: Callable[[Intention], None] | None = None
        self.states: GoalStates | None = None
        self.has_conditions = False

    # ---- events

    def post(self, event: Event) -> None:
        """Add an event to the queue."""
        # The event of an atomic intention precedes all others.
        if event.intention is not None and event.intention.atomic:
            self.atomic_event = event
        else:
            self.events.append(event)
        if self.states is not None and event.sort in ("+!", "+?"):
            self.states.note("pending", "+!", event.literal)
        if self.waits:
            self._notice(event)

    def post_state(self, event: Event) -> None:
        """Insert the event of a goal state after those of other states, before all others."""
        place = sum(1 for queued in self.events if queued.sort[0] == "^")
        self.events.insert(place, event)

    def all_events(self) -> list[Event]:
        """Return the queued events in order."""
        first = [] if self.atomic_event is None else [self.atomic_event]
        return [*first, *self.events]

    def remove_event(self, event: Event) -> None:
        """Remove an event, suspended or not, and end the intention that waits for it."""
        if event is self.atomic_event:
            self.atomic_event = None
        self.events = deque(e for e in self.events if e is not event)
        self.suspended_events = [e for e in self.suspended_events if e is not event]
        if event.intention is not None:
            self._dropped(event.intention)

    def remove_goals(self, goal: Literal, u: Unifier) -> None:
        """Remove the `+!goal` events, including suspended ones."""
        for event in [*self.events, *self.suspended_events]:
            if event.is_for(goal, dict(u)):
                self.remove_event(event)

    def clear_events(self, *, only_goals: bool = False) -> None:
        """Remove all events or those of goals, and end the intentions that wait for them."""
        for event in self.all_events():
            if event.intention is not None and (event.is_goal or not only_goals):
                self._dropped(event.intention)
        self.events = deque(e for e in self.events if only_goals and not e.is_goal)
        self.atomic_event = None
        self.suspended_events.clear()

    # ---- intentions

    def add_running(self, intention: Intention) -> None:
        """Append an intention to the queue of running intentions."""
        if intention.atomic:
            self.atomic = intention
        else:
            intention.in_line = True
            self.running.append(intention)
        if self.waits:
            self._notice(None)

    def is_running(self, intention: Intention) -> bool:
        """Return whether an intention is atomic or queued to run."""
        return intention is self.atomic or intention.in_line

    def remove_running(self, intention: Intention) -> bool:
        """Remove an intention from the running ones. Return whether it was there."""
        if intention is self.atomic:
            self.atomic = None
            return True
        # Most ending intentions are not queued and need no search.
        if not intention.in_line:
            return False
        intention.in_line = False
        self.running.remove(intention)
        return True

    def take_atomic(self) -> Intention | None:
        """Remove and return the atomic intention, or None if it is pending."""
        if self.atomic_waits:
            return None
        intention, self.atomic = self.atomic, None
        return intention

    def suspend(self, kind: str, intention: Intention, reason: Term | None = None) -> None:
        """Make an intention pending with a kind of reason."""
        if intention.atomic:
            self.atomic = intention
            self.atomic_waits = True
        self.pending[intention.number] = (kind, intention)
        intention.reason = reason
        if self.states is not None:
            state = "suspended" if kind.startswith("suspended") else "waiting"
            self.states.note_top(state, intention, reason)
        if self.waits:
            self._notice(None)

    def take_pending(self, intention: Intention, kind: str) -> bool:
        """Remove an intention pending with this kind of reason. Return whether it was there."""
        pending = self.pending.get(intention.number)
        return pending is not None and pending[0] == kind and self.unpend(intention)

    def unpend(self, intention: Intention) -> bool:
        """Remove an intention pending with any reason. Return whether it was there."""
        if self.pending.pop(intention.number, None) is None:
            return False
        self._release(intention)
        return True

    def resume(self, intention: Intention, reason: Term | None = None) -> None:
        """Queue a formerly pending intention to run."""
        self.add_running(intention)
        if self.states is not None:
            self.states.note_top("executing", intention, reason)

    def _release(self, intention: Intention) -> None:
        if intention is self.atomic:
            self.atomic = None
            self.atomic_waits = False

    def expect(self, action: PendingAction) -> None:
        """Make an intention pending for the outcome of an action."""
        intention = action.intention
        if intention.atomic:
            self.atomic = intention
            self.atomic_waits = True
        self.pending_actions[intention.number] = action
        intention.reason = action.action
        if self.states is not None:
            self.states.note_top("waiting", intention, Literal("action", (action.action,)))

    def take_action(self, intention: Intention) -> PendingAction | None:
        """Remove an intention pending for an action. Return the action, or None."""
        action = self.pending_actions.pop(intention.number, None)
        if action is not None:
            self._release(intention)
        return action

    def report(self, wanted: int | Literal, success: bool) -> bool:
        """Queue the outcome of an action, given by number or literal. Return False without one."""
        reported = [pending for pending, _ in self.feedback]
        for pending in self.pending_actions.values():
            if wanted in (pending.number, pending.action) and pending not in reported:
                self.feedback.append((pending, success))
                return True
        return False

    def has_feedback(self) -> bool:
        """Return whether an outcome has arrived for an intention that is not suspended."""
        return any(not action.intention.is_suspended for action, _ in self.feedback)

    def drop(self, intention: Intention) -> None:
        """End an intention in any state."""
        for event in [*self.all_events(), *self.suspended_events]:
            if event.intention is intention:
                self.remove_event(event)
        if self.take_action(intention) is not None:
            self._dropped(intention)
        if self.remove_running(intention):
            self._dropped(intention)
        if self.unpend(intention):
            self._dropped(intention)

    def clear_intentions(self) -> None:
        """End all intentions but the selected one, and cancel the events scheduled by `.at`."""
        for timer in self.future_events:
            timer.cancel()
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
        for event in [*self.all_events(), *self.suspended_events]:
            if event.intention is not None:
                self.remove_event(event)

    def forget(self, intention: Intention) -> None:
        """Notify `on_end` that an intention has ended."""
        if self.on_end is not None:
            self.on_end(intention)

    def intentions(self) -> Iterator[Intention]:
        """Iterate over all intentions in the search order of Jason."""
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
        if self.states is not None:
            self.states.note_all("dropped", intention)
        self.forget(intention)
        if self.waits:
            self._notice(None)

    def _notice(self, event: Event | None) -> None:
        for wait in list(self.waits):
            wait.notice(event)


class GoalStates:
    """Recorder of changes of goal states, which become events at the beginning of the next cycle.

    The states are pending, executing, waiting, suspended, resumed, failed, achieved, dropped and
    finished. The events precede all others, and are raised only if there is a plan for them.
    """

    def __init__(self, circumstance: Circumstance, plans: PlanLibrary) -> None:
        self._circumstance = circumstance
        self._plans = plans
        self._changes: list[Event] = []

    @property
    def has_changes(self) -> bool:
        """Whether goals have changed since the last cycle."""
        return bool(self._changes)

    def note(self, state: str, sort: str, goal: Literal, reason: Term | None = None) -> None:
        """Record a new state of a goal. `sort` is that of its event, `+!` or `+?`."""
        why = Literal("reason", ("" if reason is None else reason,))
        annot = Literal("state", (Literal(state),), (why,))
        self._changes.append(Event("^" + sort[1:], with_more_annots(goal, annot)))

    def note_top(self, state: str, intention: Intention, reason: Term | None = None) -> None:
        """Record the state of the goal of the active plan."""
        if intention.stack and intention.top.sort in ("+!", "+?"):
            self.note(state, intention.top.sort, intention.top.literal, reason)

    def note_all(self, state: str, intention: Intention, *, but: Literal | None = None) -> None:
        """Record a final state of all goals of an intention but `but`."""
        for means in intention.downwards():
            if means.sort in ("+!", "+?") and means.literal is not but:
                self.note(state, means.sort, means.literal)
                self.note("finished", means.sort, means.literal)

    def post(self) -> None:
        """Raise the events of the recorded changes."""
        changes, self._changes = self._changes, []
        for event in changes:
            if self._plans.candidates(event.sort, event.literal):
                self._circumstance.post_state(event)
