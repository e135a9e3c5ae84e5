"""The reasoning cycle of an agent: sense, deliberate, act.

A cycle handles timers that are due, updates the beliefs from percepts and reads one message. It
then handles one event and the outcome of one action, and carries out one step of one intention.
"""

from __future__ import annotations

from .actions import error_annots
from .errors import EndlessProgramError, ProgramProblem, TooDeepError
from .internal_actions.messages import read
from .language.terms import ONLY_SELF, Literal
from .reasoning.circumstance import Refused
from .reasoning.deliberation import clear, deliberate, finish_satisfied, move_on
from .reasoning.execution import OPERATIONS
from .reasoning.failure import fail
from .reasoning.intentions import Event
from .reasoning.plans import SLEEPING
from .reasoning.state import SECOND, AgentState, nanoseconds


class ReasoningCycle:
    """Reasoning cycles of one agent."""

    def __init__(self, state: AgentState, max_cycles: int) -> None:
        self._state = state
        self._max_cycles = max_cycles
        self._has_begun = False

    @property
    def next_wakeup(self) -> float | None:
        """Time in seconds of the next activity without external input, or None."""
        if not self._has_begun or self._state.mailbox:
            return self._state.now
        due = self._state.alarms.next
        return None if due is None else due / SECOND

    def advance(self, time: float) -> None:
        """Run until there is nothing left to do at `time` (s). Raises as `Agent.advance`."""
        state = self._state
        clock = nanoseconds(time)
        if clock < state.clock:
            raise ValueError(f"time must not decrease, but {time} s is before {state.now} s")
        # Fast path, because there is often nothing to do.
        if self._has_begun and not (
            state.percepts.coming
            or state.alarms.heap
            or state.mailbox
            or state.circumstance.feedback
        ):
            state.clock, state.now = clock, time
            return
        percepts = state.percepts
        percepts.at_once = True
        try:
            if not self._has_begun:
                # The initial goals come first, at the start time, before any percept.
                self._has_begun = True
                self._run_instant()
            if state.alarms.heap:
                self._run_until(clock)
            state.clock, state.now = clock, time
            if percepts.coming:
                percepts.apply()
            self._run_instant()
        except RecursionError:
            raise EndlessProgramError([self.problem("a term is nested too deeply")]) from None
        except TooDeepError as error:
            raise EndlessProgramError([self.problem(str(error))]) from None
        finally:
            percepts.at_once = False

    def problem(self, message: str) -> ProgramProblem:
        """Return a problem of the plan that is being carried out or selected."""
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
        return ProgramProblem(file=state.program.source, message=message)

    def _run_until(self, clock: int) -> None:
        """Run all activities due before a time (ns), each at its own time."""
        state = self._state
        due = state.alarms.next
        while due is not None and due < clock:
            state.clock, state.now = due, due / SECOND
            self._run_instant()
            due = state.alarms.next

    def _run_instant(self) -> None:
        """Run cycles until there is nothing left to do at the current time.

        Raises `EndlessProgramError` if that takes more than the maximum number of cycles.
        """
        state = self._state
        circumstance, logic, percepts, plans = (
            state.circumstance,
            state.logic,
            state.percepts,
            state.plans,
        )
        tasks, mailbox, alarms = state.tasks, state.mailbox, state.alarms.heap
        running, feedback = circumstance.running, circumstance.feedback
        logic.begin_instant()
        # Without external input, an agent that does not finish is in an endless loop.
        for _ in range(self._max_cycles):
            has_work = circumstance.atomic is None and (running or circumstance.events)
            if not has_work and not self._goes_on():
                return
            if logic.goals_left != logic.max_goals:
                logic.begin_cycle()
            circumstance.selected_event = circumstance.selected = None
            if (
                alarms
                or percepts.changed
                or tasks
                or mailbox
                or plans.has_sleep
                or circumstance.states is not None
            ):
                self._sense()
            if circumstance.atomic is None and (circumstance.events or circumstance.atomic_event):
                deliberate(state)
            if circumstance.has_conditions:
                finish_satisfied(state)
            if feedback:
                self._take_feedback()
            if circumstance.atomic is not None:
                intention = circumstance.take_atomic()
            elif running:
                intention = running.popleft()
                intention.in_line = False
            else:
                continue
            if intention is None or not intention.stack:
                continue
            circumstance.selected = intention
            means = intention.stack[-1]
            step = means.step
            if step is None:
                move_on(state, intention, means)
                continue
            OPERATIONS[step.operation](state, intention, means, step)
            if means.step is None and intention.stack:
                clear(state, intention)
        if self._goes_on():
            limit = f"more than {self._max_cycles} cycles at {state.now:g} s"
            raise EndlessProgramError([self.problem(f"{limit}: this plan does not end")])

    def _goes_on(self) -> bool:
        """Return whether there is work, or a plan for idle agents may apply."""
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
            if not circumstance.atomic_waits:
                return True
        elif circumstance.events or circumstance.running or circumstance.atomic_event is not None:
            return True
        return state.plans.has_sleep and not state.sleeps and not state.is_stopped

    def _sense(self) -> None:
        state = self._state
        if state.alarms.heap:
            state.alarms.run_due(state.clock)
        if state.percepts.changed:
            for sort, literal in state.percepts.update(state.beliefs):
                if state.is_observed:
                    state.note("percept", f"{sort}{literal}")
                state.changed(sort, literal, None)
        if state.plans.has_sleep:
            self._fall_asleep_or_wake()
        if state.mailbox:
            read(state, state.mailbox.popleft())
        # After percepts and messages, so that waits which they end are resumed in this cycle.
        while state.tasks:
            state.tasks.popleft()()
        if state.circumstance.states is not None:
            state.circumstance.states.post()

    def _fall_asleep_or_wake(self) -> None:
        """Raise the event of becoming idle or of having work again."""
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
            pending, outcome = circumstance.feedback.popleft()
            intention = pending.intention
            # The intention has ended or continued without this outcome.
            if circumstance.pending_actions.get(intention.number) is not pending:
                continue
            circumstance.take_action(intention)
            if outcome:
                move_on(state, intention, intention.top)
                if circumstance.states is not None:
                    done = Literal("action_executed", (pending.action,))
                    for means in intention.downwards():
                        if means.is_goal:
                            circumstance.states.note("executing", means.sort, means.literal, done)
            else:
                reason = outcome.reason if isinstance(outcome, Refused) else ""
                fail(state, intention, error_annots("action_failed", ""), reason)
            return
