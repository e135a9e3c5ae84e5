"""The reasoning cycle of Jason: sense, deliberate, act.

A cycle wakes what is due, updates the beliefs from percepts and reads one message; takes one event;
takes the outcome of one action and carries out one step of one intention.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from ..errors import EndlessProgramError, Problem
from ..language.terms import ONLY_SELF, Literal
from .achievement import finish_satisfied
from .actions import error_annots
from .circumstance import PendingAction
from .deliberation import clear, deliberate, move_on
from .execution import OPERATIONS
from .failure import fail
from .intentions import Event
from .mail import read
from .plans import SLEEPING
from .state import SECOND, AgentState


class Pending:
    """Answer of `act` for an action whose outcome comes later, by `Agent.finish`."""

    def __repr__(self) -> str:
        return "bdi.PENDING"


PENDING = Pending()
"""The answer of `act` for an action whose outcome is not known yet."""

Perform: TypeAlias = "Callable[[Literal], bool | Pending]"


class ReasoningCycle:
    """Runs the cycles of one agent; `act` carries out its external actions."""

    def __init__(self, state: AgentState, act: Perform | None, max_cycles: int) -> None:
        self._state = state
        self._act = act
        self._max_cycles = max_cycles

    def run_until(self, clock: int, time: float) -> None:
        """Run all that is due before a time, each at its own, and set the time.

        Args:
            clock: the time (ns).
            time: the same time as the caller gave it (s).
        """
        state = self._state
        due = state.alarms.next
        while due is not None and due < clock:
            state.clock, state.now = due, due / SECOND
            self.run_instant()
            due = state.alarms.next
        state.clock, state.now = clock, time

    def run_instant(self) -> None:
        """Run cycles until nothing is left to do at the present time.

        Raises:
            EndlessProgramError: that takes more cycles than one instant may have.
        """
        cycles = 0
        state = self._state
        circumstance = state.circumstance
        state.logic.begin_instant()
        while (circumstance.running and circumstance.atomic is None) or self._goes_on():
            cycles += 1
            if cycles > self._max_cycles:
                limit = f"more than {self._max_cycles} cycles at {state.now:g} s"
                raise EndlessProgramError([self.problem(f"{limit}: this plan does not end")])
            self._cycle()

    def _goes_on(self) -> bool:
        """Return True if there is work, or a plan may be called because there is none."""
        state = self._state
        if self._has_work():
            return True
        return state.plans.has_sleep and not state.sleeps and not state.is_stopped

    def _has_work(self) -> bool:
        state, circumstance = self._state, self._state.circumstance
        if state.percepts.changed or state.tasks or state.mailbox:
            return True
        if circumstance.states is not None and circumstance.states.has_changes:
            return True
        if state.alarms.heap and state.alarms.is_due(state.clock):
            return True
        if circumstance.feedback and circumstance.has_feedback():
            return True
        if circumstance.atomic is not None:
            return not circumstance.atomic_waits
        return bool(
            circumstance.events or circumstance.running or circumstance.atomic_event is not None
        )

    def _cycle(self) -> None:
        state, circumstance = self._state, self._state.circumstance
        state.logic.begin_cycle()
        circumstance.selected_event = circumstance.selected = None
        if (
            state.alarms.heap
            or state.tasks
            or state.percepts.changed
            or state.mailbox
            or state.plans.has_sleep
            or circumstance.states is not None
        ):
            self._sense()
        if circumstance.atomic is None and (circumstance.events or circumstance.atomic_event):
            deliberate(state)
        if circumstance.has_conditions:
            finish_satisfied(state)
        if circumstance.feedback:
            self._take_feedback()
        intention = circumstance.select()
        circumstance.selected = intention
        if intention is None or not intention.stack:
            return
        means = intention.stack[-1]
        step = means.step
        if step is None:
            move_on(state, intention, means)
        else:
            OPERATIONS[step.operation](state, intention, means, step)
            if means.step is None and intention.stack:
                clear(state, intention)
        if state.requested is not None:
            self._perform(state.requested)

    def _sense(self) -> None:
        state = self._state
        state.alarms.ring(state.clock)
        if state.percepts.changed:
            for event in state.percepts.update(state.beliefs):
                state.note("percept", event)
                state.circumstance.post(event)
        if state.plans.has_sleep:
            self._fall_asleep_or_wake()
        if state.mailbox:
            read(state, state.mailbox.popleft())
        # After percepts and mail: those whose wait they end run on in this very cycle.
        while state.tasks:
            state.tasks.popleft()()
        if state.circumstance.states is not None:
            state.circumstance.states.post()

    def _fall_asleep_or_wake(self) -> None:
        """Raise the event of having nothing to do, or of having something again."""
        state, circumstance = self._state, self._state.circumstance
        is_idle = not (state.mailbox or state.tasks or circumstance.feedback)
        if circumstance.atomic is None or not circumstance.atomic_waits:
            is_idle = is_idle and not any(
                name not in SLEEPING
                for name in (
                    *(event.literal.functor for event in circumstance.all_events()),
                    *(running.stack[0].literal.functor for running in circumstance.running),
                )
            )
        if is_idle is not state.sleeps:
            state.sleeps = is_idle
            name = "jag_sleeping" if is_idle else "jag_awaking"
            circumstance.post(Event("+", Literal(name, (), ONLY_SELF)))

    def _take_feedback(self) -> None:
        state, circumstance = self._state, self._state.circumstance
        while circumstance.feedback:
            pending, success = circumstance.feedback.popleft()
            intention = pending.intention
            if circumstance.pending_actions.get(intention.number) is not pending:
                continue
            circumstance.take_action(intention)
            if success:
                if circumstance.states is not None:
                    done = Literal("action_executed", (pending.action,))
                    circumstance.states.note_top("executing", intention, done)
                move_on(state, intention, intention.top)
            else:
                fail(state, intention, error_annots("action_failed", ""))
            return

    def _perform(self, pending: PendingAction) -> None:
        state = self._state
        state.requested = None
        state.circumstance.expect(pending)
        state.note("action", pending.action, pending.intention)
        outcome = True if self._act is None else self._act(pending.action)
        if not isinstance(outcome, Pending):
            state.circumstance.feedback.append((pending, bool(outcome)))

    def problem(self, message: str) -> Problem:
        """Return a problem of the plan that is being carried out or looked for."""
        state, circumstance = self._state, self._state.circumstance
        selected, event = circumstance.selected, circumstance.selected_event
        if selected is not None and selected.stack:
            intentions, events = [selected], []
        elif event is not None:
            intentions, events = [], [event]
        else:
            intentions, events = list(circumstance.intentions()), circumstance.all_events()
        if intentions:
            means = intentions[0].top
            return means.place.problem(f"{means.plan.plan.trigger}: {message}")
        for event in events:
            for plan in state.plans.candidates(event.sort, event.literal):
                return plan.plan.place.problem(f"{plan.plan.trigger}: {message}")
        return Problem(state.program.source, 0, 0, message)
