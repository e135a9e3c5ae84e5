"""An agent: the reasoning cycle (sense, deliberate, act), and the interface to its environment.

A cycle wakes what is due, updates the beliefs from percepts and reads one message; takes one event;
takes the outcome of one action and carries out one step of one intention.

Time belongs to the caller: `advance(t)` runs reasoning cycles until nothing is left to do at t.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from typing import NoReturn

from .actions import InternalAction, error_annots
from .errors import EndlessProgramError, ProgramError, ProgramProblem, TooDeepError
from .internal_actions import STANDARD
from .internal_actions.messages import read
from .language.loading import parse_literal
from .language.program import Belief, Program
from .language.terms import ONLY_SELF, Literal
from .reasoning.beliefs import LiveBeliefs
from .reasoning.circumstance import Perform, Refused
from .reasoning.deliberation import clear, deliberate, finish_satisfied, move_on
from .reasoning.execution import OPERATIONS, call_in_query
from .reasoning.failure import fail
from .reasoning.intentions import Event, Intention
from .reasoning.plans import SLEEPING
from .reasoning.state import (
    KINDS,
    SECOND,
    AgentState,
    Entry,
    add_program as load_program,
    nanoseconds,
    start as start_program,
)
from .society import Message, Society


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
        # Most calls find nothing to do: time passes, and that is all.
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
                # Its initial goals come first, at the time it was made, before any percept.
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
        # At one instant nothing from outside comes, so an agent that is never done is a loop.
        for _ in range(self._max_cycles):
            has_work = circumstance.atomic is None and (running or circumstance.events)
            if not has_work and not self._goes_on():
                return
            # Each cycle has a budget of goals; one that has tried none needs no new one.
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
        """Return True if there is work, or if a plan for idle agents may apply."""
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
        # After percepts and mail: those whose wait they end run on in this very cycle.
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
            # The intention was dropped, or has gone on without this outcome.
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


class Agent:
    """BDI agent that runs one program.

    Parameters
    ----------
    program : Program
        Initial beliefs, initial goals and plans.
    beliefs : iterable of str or Literal, optional
        Further initial beliefs. They precede those of the program.
    act : callable, optional
        Function that carries out an external action, given as a `Literal`. It returns True if the
        action was done, False or `Refused` if it failed, or `PENDING` if the outcome follows by
        `finish`. By default every action succeeds.
    name : str, optional
        Answer of `.my_name` and sender of messages.
    seed : int, optional
        Random seed. If agents of a society have the same seed, the random numbers of all but the
        first also depend on their names.
    start : float, optional
        Start time in seconds. Defaults to the time of the society.
    print : callable, optional
        Function called with each line of `.print`. By default lines go to standard output.
    on_event : callable, optional
        Function called with an `Entry` for each internal event, such as the `append` of
        `collections.deque(maxlen=10_000)`.
    kinds : collection of str, optional
        Kinds of entries passed to `on_event`. Defaults to all kinds.
    live : mapping, optional
        Functions that answer queries instead of stored beliefs, by (functor, arity). Each returns
        the argument tuples that hold at the time of the query. These beliefs have the source
        `percept`, raise no events, and are not part of `beliefs`.
    actions : mapping, optional
        Further internal actions by name. See `InternalActions`.
    strict : bool, optional
        Reject programs that call unknown internal actions. By default such a call causes a warning,
        and the plan that contains it fails.
    society : Society, optional
        Agents that can exchange messages with this one. By default an agent can only send messages
        to itself.
    max_cycles : int, optional
        Maximum number of reasoning cycles at one time.
    max_goals : int, optional
        Maximum number of goals tried in one cycle.
    max_depth : int, optional
        Maximum number of plans in an intention.
    max_intentions : int, optional
        Maximum number of simultaneous intentions.

    Attributes
    ----------
    beliefs : BeliefBase
        Belief base. Iteration yields the beliefs.
    plans : PlanLibrary
        Plan library.

    Raises
    ------
    ProgramError
        If the program uses an internal action where it is not allowed, uses a label twice or, if
        `strict`, calls an unknown internal action. Also if the text of a belief is invalid.
    TypeError
        If `program` is not a `Program`.
    ValueError
        If the society already has an agent of that name.

    Examples
    --------
    >>> lines = []
    >>> agent = bdi.Agent(bdi.parse("!greet. +!greet <- .print(hello)."), print=lines.append)
    >>> agent.advance(0.0)
    >>> lines
    ['hello']
    """

    def __init__(
        self,
        program: Program,
        *,
        beliefs: Iterable[str | Literal] = (),
        act: Perform | None = None,
        name: str = "human",
        seed: int = 0,
        start: float | None = None,
        print: Callable[[str], None] | None = None,
        on_event: Callable[[Entry], None] | None = None,
        kinds: Collection[str] = KINDS,
        live: LiveBeliefs | None = None,
        actions: Mapping[str, InternalAction] | None = None,
        strict: bool = False,
        society: Society | None = None,
        max_cycles: int = 3_000_000,
        max_goals: int = 1_000_000,
        max_depth: int = 200_000,
        max_intentions: int = 20_000,
    ) -> None:
        if not isinstance(program, Program):
            raise TypeError(f"program must be a bdi.Program (see bdi.load), not {program!r}")
        society = Society() if society is None else society
        self.name = name
        self.program = program
        self.actions: Mapping[str, InternalAction] = (
            {**STANDARD, **actions} if actions else STANDARD
        )
        self._state = AgentState(
            program,
            name,
            call_in_query,
            actions=self.actions,
            strict=strict,
            live=live or {},
            seed=society.own_seed(name, seed),
            start=society.now if start is None else start,
            act=act,
            print=print,
            on_event=on_event,
            kinds=kinds,
            society=society,
            functions=getattr(actions, "functions", None),
            max_goals=max_goals,
            max_depth=max_depth,
            max_intentions=max_intentions,
        )
        self.beliefs = self._state.beliefs
        self.plans = self._state.plans
        self._cycle = ReasoningCycle(self._state, max_cycles)
        extra = [Belief(_as_literal(belief)) for belief in beliefs]
        try:
            start_program(self._state, extra)
        except (RecursionError, TooDeepError):
            message = "a formula or a term is nested too deeply"
            raise ProgramError([ProgramProblem(file=program.source, message=message)]) from None
        society.join(self)

    def __repr__(self) -> str:
        counts = f"{len(self.beliefs)} beliefs, {len(self.intentions)} intentions"
        return f"<Agent {self.name} at {self.now:g} s: {counts}>"

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            "an agent cannot be copied or pickled, because it holds its callbacks and its society;"
            " make another one, bdi.Agent(agent.program, …)"
        )

    # ---- time

    @property
    def now(self) -> float:
        """Time in seconds to which the agent has advanced."""
        return self._state.now

    @property
    def next_wakeup(self) -> float | None:
        """Time in seconds of the next activity without external input, or None."""
        return self._cycle.next_wakeup

    def advance(self, time: float) -> None:
        """Run reasoning cycles until there is nothing left to do at `time`.

        Activities due earlier take place at their own times, in order. Percepts and outcomes that
        arrived since the last call count at `time`.

        Parameters
        ----------
        time : float
            Time in seconds, at least `now`.

        Raises
        ------
        ValueError
            If the time is before `now` or not finite.
        EndlessProgramError
            If the agent exceeds its maximum number of cycles, goals, plans or intentions.
        """
        self._cycle.advance(time)

    # ---- percepts, actions and messages

    @property
    def percepts(self) -> list[Literal]:
        """Current percepts in order of arrival."""
        return self._state.percepts.current

    def add_percept(self, percept: str | Literal) -> None:
        """Add a percept at the time of the next `advance`.

        While the agent runs, for example in `act`, the percept is added immediately.

        Parameters
        ----------
        percept : str or Literal
            Percept. The agent believes it with the source `percept`.

        Raises
        ------
        ProgramError
            If the text is not one literal.
        """
        literal = percept if percept.__class__ is Literal else _as_literal(percept)
        self._state.percepts.queue((True, literal))

    def remove_percept(self, percept: str | Literal) -> None:
        """Remove a percept at the time of the next `advance`.

        While the agent runs, the percept is removed immediately. Unknown percepts are ignored.

        Parameters
        ----------
        percept : str or Literal
            Percept.

        Raises
        ------
        ProgramError
            If the text is not one literal.
        """
        literal = percept if percept.__class__ is Literal else _as_literal(percept)
        self._state.percepts.queue((False, literal))

    @property
    def pending_actions(self) -> dict[int, Literal]:
        """External actions without an outcome yet, by number."""
        pending = self._state.circumstance.pending_actions.values()
        return {one.number: one.action for one in pending}

    def finish(self, action: int | str | Literal, success: bool = True) -> None:
        """Report the outcome of an action for which `act` returned `PENDING`.

        Parameters
        ----------
        action : int, str or Literal
            The action or its number (see `pending_actions`).
        success : bool, optional
            Whether the action was done. Otherwise the plan that contains it fails.

        Raises
        ------
        ValueError
            If no such action is pending.
        ProgramError
            If the text of the action is not one literal.
        """
        wanted = action if isinstance(action, int) else _as_literal(action)
        if not self._state.circumstance.report(wanted, success):
            raise ValueError(f"no action {action} is pending")

    def receive(self, message: Message) -> None:
        """Add a message to the mailbox. Each cycle reads one.

        Parameters
        ----------
        message : Message
            Message to this agent.
        """
        self._state.mailbox.append(message)

    # ---- its mind

    def problem(self, message: str) -> ProgramProblem:
        """Return a problem located at the step that is being carried out.

        With it, `act` can report the line of an invalid action.

        Parameters
        ----------
        message : str
            Description of the problem.

        Returns
        -------
        ProgramProblem
            Problem with file and line.
        """
        return self._cycle.problem(message)

    @property
    def intentions(self) -> list[Intention]:
        """Current intentions. Each is a stack of plans, the active plan last."""
        return list(self._state.circumstance.intentions())

    @property
    def is_stopped(self) -> bool:
        """Whether the program has ended by `.stopMAS`."""
        return self._state.is_stopped

    def add_program(self, program: Program) -> None:
        """Add plans after the existing ones, then beliefs and goals, which raise events.

        Parameters
        ----------
        program : Program
            Program to add.

        Raises
        ------
        ProgramError
            If the program uses an internal action where it is not allowed, uses a label twice or,
            if `strict`, calls an unknown internal action.
        """
        load_program(self._state, program)

    def believe(self, literal: Literal) -> None:
        """Add a belief and raise its event.

        Parameters
        ----------
        literal : Literal
            Belief. Its source is `self` unless it has one.
        """
        self._state.believe(literal)

    def disbelieve(self, literal: Literal) -> None:
        """Remove a belief and raise its event.

        Parameters
        ----------
        literal : Literal
            Belief. Its source is `self` unless it has one.
        """
        self._state.disbelieve(literal)


def _as_literal(value: str | Literal) -> Literal:
    return parse_literal(value) if isinstance(value, str) else value
