"""An agent: beliefs, plans and intentions, and the cycle that brings them together.

The cycle is Jason's: sense (percepts, one message), deliberate (one event),
act (the outcome of one action, one step of one intention). Time belongs to the
caller: `advance(t)` runs cycles until nothing is left to do at t.
"""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from itertools import count
from random import Random
from typing import TYPE_CHECKING, TypeAlias

from .alarms import Alarms
from .beliefs import BeliefBase, LiveBeliefs
from .circumstance import Circumstance, PendingAction
from .deliberation import clear, deliberate
from .errors import EndlessProgramError, Problem, ProgramError, TooDeepError
from .failure import ActionError, error_annots, fail
from .history import Entry
from .intentions import Event, Intention, Means
from .internal_actions import STANDARD, Call, InternalAction
from .loading import check_actions
from .logic import Answer, Logic
from .parser import parse_literal
from .percepts import Percepts
from .plans import PlanLibrary
from .program import Belief, Program, Rule
from .run_functions import with_run_functions
from .steps import Waiting, with_source
from .terms import TRUE, Literal
from .unify import Names, Unifier, rename, substitute, substitute_literal

if TYPE_CHECKING:
    from .society import Message, Society


class Pending:
    """What `act` answers when the outcome of an action comes later, by `Agent.finish`."""

    def __repr__(self) -> str:
        return "bdi.PENDING"


PENDING = Pending()
"""For `act` to answer: the outcome is not known yet."""

Perform: TypeAlias = "Callable[[Literal], bool | Pending]"

_LOG = logging.getLogger("bdi")
_SECOND = 1e9


def _clock(seconds: float) -> int:
    """Nanoseconds: in these times add up exactly, and 0.1 + 0.2 is 0.3."""
    if not math.isfinite(seconds):
        raise ValueError(f"a time is a number of seconds, not {seconds}")
    return round(seconds * _SECOND)


class Agent:
    """Runs one program.

    Args:
        program: what it believes, wants and knows to do at the start.
        beliefs: more initial beliefs, as text or terms; they come before the program's.
        act: performs an external action; returns True when it is done, False when it
            failed, or `PENDING` when `finish` will tell. Without it every action succeeds.
        name: what `.my_name` answers, and who its messages come from.
        seed: of the agent's random numbers.
        start: the time at which it begins, in seconds.
        print: takes what `.print` prints. Without it, it goes to standard output.
        on_event: takes an `Entry` for everything that happens inside, as `History.add` does.
        live: beliefs that are asked for and not remembered, by functor and arity: each a function
            that returns the arguments of what holds when it is called, as often as a query comes
            to it. They have the source `percept`, raise no events and are not in `beliefs`.
        actions: further internal actions, by name (see `InternalActions`).
        society: the agents it can send messages to.
        max_cycles: how many cycles one instant may take before the agent is stopped.
        max_goals: how many goals one cycle may try to prove: by default seconds of work,
            where a handful is usual.
        max_depth: how many plans an intention may hold.
        max_intentions: how many intentions there may be at once.

    Raises:
        ProgramError: the program uses internal actions that do not exist, or one label twice.
    """

    def __init__(
        self,
        program: Program,
        *,
        beliefs: Iterable[str | Literal] = (),
        act: Perform | None = None,
        name: str = "human",
        seed: int = 0,
        start: float = 0.0,
        print: Callable[[str], None] | None = None,
        on_event: Callable[[Entry], None] | None = None,
        live: LiveBeliefs | None = None,
        actions: Mapping[str, InternalAction] | None = None,
        society: Society | None = None,
        max_cycles: int = 3_000_000,
        max_goals: int = 1_000_000,
        max_depth: int = 200_000,
        max_intentions: int = 20_000,
    ) -> None:
        if not isinstance(program, Program):
            raise TypeError(f"expected a program, as bdi.load reads one, found {program!r}")
        self.program = program
        self.name = name
        self.random = Random(seed)
        self.actions: Mapping[str, InternalAction] = {**STANDARD, **(actions or {})}
        self.names = Names()
        self.beliefs = BeliefBase(live or {})
        self.plans = PlanLibrary()
        self.circumstance = Circumstance()
        self.logic = Logic(self.beliefs, self.names, self._call_in_query, max_goals)
        self.alarms = Alarms()
        self.society = society
        self.clock = _clock(start)
        self.max_depth = max_depth
        self._max_cycles = max_cycles
        self._max_intentions = max_intentions
        self._act = act
        self._print = print
        self._on_event = on_event
        self._now = float(start)
        self._begun = False
        self._running = False
        self._stopped = False
        self._percepts = Percepts()
        self._mailbox: deque[Message] = deque()
        self._tasks: deque[Callable[[], None]] = deque()
        self._intention_numbers = count(1)
        self._action_numbers = count(1)
        self._requested: PendingAction | None = None
        if on_event is not None:
            self.circumstance.on_end = self._note_end
        check_actions(program, self.actions)
        extra = tuple(Belief(_as_literal(belief)) for belief in beliefs)
        try:
            self.add_program(replace(program, beliefs=extra + program.beliefs))
        except (RecursionError, TooDeepError):
            message = "a formula or a term is nested too deeply"
            raise ProgramError([Problem(program.source, 0, 0, message)]) from None
        if society is not None:
            society.join(self)

    # ---- the caller's side

    @property
    def now(self) -> float:
        """The time of what is being done, in seconds."""
        return self._now

    @property
    def next_wakeup(self) -> float | None:
        """When something happens without anything new from outside, in seconds; or None."""
        if not self._begun or self._mailbox:
            return self._now
        due = self.alarms.next
        return None if due is None else due / _SECOND

    @property
    def intentions(self) -> list[Intention]:
        """What the agent is up to: each intention a stack of plans, the last one at work."""
        return list(self.circumstance.intentions())

    @property
    def percepts(self) -> list[Literal]:
        """What is perceived now, in the order in which it came."""
        return self._percepts.current

    @property
    def has_mail(self) -> bool:
        """Whether messages wait to be read."""
        return bool(self._mailbox)

    @property
    def pending_actions(self) -> dict[int, Literal]:
        """The external actions whose outcome is open, by number."""
        return {a.number: a.action for a in self.circumstance.pending_actions.values()}

    @property
    def is_stopped(self) -> bool:
        """Whether the program has ended itself by `.stopMAS`."""
        return self._stopped

    def add_percept(self, percept: str | Literal) -> None:
        """Something is perceived from the time of the next `advance` on.

        While the agent runs, as in `act`, it is perceived at once.
        """
        self._percepts.arrive(_as_literal(percept), added=True, at_once=self._running)

    def remove_percept(self, percept: str | Literal) -> None:
        """Something is no longer perceived from the time of the next `advance` on."""
        self._percepts.arrive(_as_literal(percept), added=False, at_once=self._running)

    def finish(self, action: int | str | Literal, success: bool = True) -> None:
        """Tells the outcome of an action that `act` left PENDING.

        Args:
            action: its number (see `pending_actions`) or the action itself.
            success: whether it was done; its plan fails when it was not.

        Raises:
            ValueError: no such action is open.
        """
        wanted = action if isinstance(action, int) else _as_literal(action)
        told = [pending for pending, _ in self.circumstance.feedback]
        for pending in self.circumstance.pending_actions.values():
            if wanted in (pending.number, pending.action) and pending not in told:
                self.circumstance.feedback.append((pending, success))
                return
        raise ValueError(f"no action {action} is waiting for its outcome")

    def advance(self, time: float) -> None:
        """Runs until nothing is left to do at `time`, in seconds.

        What was to wake up before is woken at its own time, in order. Percepts
        and outcomes that came since the last call count at `time`.

        Raises:
            ValueError: the time is before `now`, or no number of seconds.
            EndlessProgramError: a plan goes on for ever at one instant, or there are too many
                intentions.
        """
        target = _clock(time)
        if target < self.clock:
            raise ValueError(f"time goes forward: {time} s comes before {self._now} s")
        if self._is_idle():
            self.clock, self._now = target, time
            return
        self._running = True
        try:
            if not self._begun:
                self._begun = True
                self._run_instant()
            due = self.alarms.next
            while due is not None and due < target:
                self.clock, self._now = due, due / _SECOND
                self._run_instant()
                due = self.alarms.next
            self.clock, self._now = target, time
            self._percepts.come()
            self._run_instant()
        except RecursionError:
            raise EndlessProgramError([self._here("a term is nested too deeply")]) from None
        except TooDeepError as error:
            raise EndlessProgramError([self._here(str(error))]) from None
        finally:
            self._running = False

    def _is_idle(self) -> bool:
        return not (
            not self._begun
            or self._percepts.are_coming
            or self.alarms.heap
            or self._mailbox
            or self.circumstance.feedback
        )

    # ---- loading

    def add_program(self, program: Program) -> None:
        """Adds plans after those there are, then beliefs and goals, which raise events."""
        program = with_run_functions(
            program,
            {
                "math.random": lambda limit=1.0: self.random.random() * limit,
                "system.time": lambda: float(self.clock // 1_000_000),
            },
        )
        for plan in program.plans:
            try:
                self.plans.add(plan)
            except ValueError as error:
                place = plan.place
                problem = Problem(place.file, place.line, place.column, str(error))
                raise ProgramError([problem]) from None
        # Each belief goes to the front, so that the first of them stands first in the end.
        for clause in reversed(program.beliefs):
            self._add_initial(clause)
        for goal in program.goals:
            literal = rename(with_source(goal.goal), self.names, {})
            self.circumstance.post(Event("+!", literal))  # type: ignore[arg-type]

    def _add_initial(self, clause: Belief | Rule) -> None:
        if isinstance(clause, Rule):
            self.beliefs.add_rule(Rule(with_source(clause.head), clause.body, clause.place))
            return
        literal = substitute_literal(clause.belief, {})
        if literal.ground:
            self.believe(literal)
        else:
            self.beliefs.add_rule(Rule(with_source(literal), TRUE, clause.place))

    # ---- what plans and internal actions do

    def believe(self, literal: Literal) -> None:
        """Adds a belief, from the agent itself when it names no source, and raises its event."""
        added = self.beliefs.add(with_source(literal))
        if added is not None:
            self.circumstance.post(Event("+", added))

    def disbelieve(self, literal: Literal) -> None:
        """Takes a belief back, its own when `literal` names no source, and raises the event."""
        removed = self.beliefs.remove(with_source(literal), {})
        if removed is not None:
            self.circumstance.post(Event("-", removed))

    def say(self, line: str) -> None:
        """What `.print` does."""
        self.note("print", line)
        if self._print is None:
            print(line)
        else:
            self._print(line)

    def warn(self, line: str, intention: Intention | None = None) -> None:
        """Logs `line` about what went wrong, and tells `on_event` which `intention` it was."""
        _LOG.warning("%s: %s", self.name, line)
        self.note("warning", line, intention)

    def note(self, kind: str, what: object, intention: Intention | None = None) -> None:
        """Tells `on_event` of something."""
        if self._on_event is None:
            return
        number = 0 if intention is None else intention.number
        place = None
        if intention is not None and intention.stack:
            place = intention.top.place
        file, line = ("", 0) if place is None else (place.file, place.line)
        self._on_event(Entry(self._now, kind, str(what), number, file, line))

    def stop(self) -> None:
        """Ends the program: nothing runs any more."""
        self._stopped = True
        self.circumstance.clear_intentions()
        self.circumstance.clear_events()
        self.alarms.clear()
        self._tasks.clear()

    def at_next_cycle(self, task: Callable[[], None]) -> None:
        """Has `task` done at the beginning of the next cycle."""
        self._tasks.append(task)

    def next_intention_number(self) -> int:
        """A number that no intention of this agent has yet.

        Raises:
            TooDeepError: there are as many intentions as may be.
        """
        if self.circumstance.size >= self._max_intentions:
            raise TooDeepError(f"more than {self._max_intentions:,} intentions at once")
        return next(self._intention_numbers)

    def changed(self, sort: str, literal: Literal, intention: Intention | None) -> bool:
        """Raises the event of a change of belief; False when the intention can just go on.

        It can when nobody would take notice: there is no plan and nobody waits
        for the event, and it would be the next one taken, so that whether it is
        raised makes no difference.
        """
        circumstance = self.circumstance
        if (
            circumstance.events
            or circumstance.waits
            or circumstance.atomic is not None
            or circumstance.atomic_event is not None
            or self._tasks
            or self._mailbox
            or self._percepts.changed
            or (self.alarms.heap and self.alarms.is_due(self.clock))
            or self.plans.candidates(sort, literal)
        ):
            circumstance.post(Event(sort, literal, intention))
            return True
        return False

    def move_on(self, intention: Intention, means: Means) -> None:
        """The current step is done: the intention goes to the end of the queue."""
        if means.step is not None:
            means.step = means.step.next
        if intention.atomic:
            # It has the next cycle to itself even when its atomic plan is over.
            self.circumstance.add_running(intention)
            if means.step is None:
                clear(self, intention)
            return
        if means.step is None:
            clear(self, intention)
        if intention.stack:
            self.circumstance.add_running(intention)

    def request(self, action: Literal, intention: Intention) -> None:
        """An external action is to be done at the end of this cycle."""
        self._requested = PendingAction(next(self._action_numbers), action, intention)

    def call(self, action: Literal, u: Unifier, intention: Intention | None) -> Answer | Waiting:
        """Runs an internal action. Raises ActionError when it cannot be done."""
        internal = self.actions.get(action.functor)
        if internal is None:
            raise ActionError(f"there is no internal action {action.functor}", "unknown")
        internal.check(action.functor, len(action.args))
        args = tuple([substitute(arg, u) for arg in action.args])
        answer: Answer | Waiting = internal.function(Call(self, u, intention), *args)
        return answer

    def _call_in_query(self, action: Literal, u: Unifier) -> Answer:
        try:
            answer = self.call(action, u, None)
        except ActionError as error:
            self.warn(f"{action.functor}: {error.message}")
            return False
        return True if isinstance(answer, Waiting) else answer

    def receive(self, message: Message) -> None:
        """Puts a message into the mailbox, from which each cycle reads one."""
        self._mailbox.append(message)

    # ---- the cycle

    def _run_instant(self) -> None:
        cycles = 0
        circumstance = self.circumstance
        self.logic.begin_instant()
        while (circumstance.running and circumstance.atomic is None) or self._has_work():
            cycles += 1
            if cycles > self._max_cycles:
                limit = f"more than {self._max_cycles} cycles at {self._now:g} s"
                raise EndlessProgramError([self._here(f"{limit}: this plan does not end")])
            self._cycle()

    def _has_work(self) -> bool:
        circumstance = self.circumstance
        if self._percepts.changed or self._tasks or self._mailbox:
            return True
        if self.alarms.heap and self.alarms.is_due(self.clock):
            return True
        if circumstance.feedback and circumstance.has_feedback():
            return True
        if circumstance.atomic is not None:
            return not circumstance.atomic_waits
        return bool(
            circumstance.events or circumstance.running or circumstance.atomic_event is not None
        )

    def _here(self, message: str) -> Problem:
        """What is wrong with the plan that is at work."""
        circumstance = self.circumstance
        selected, event = circumstance.selected, circumstance.selected_event
        events = circumstance.all_events()
        intentions = circumstance.intentions()
        if selected is not None and selected.stack:
            intentions = iter((selected,))
        elif event is not None:
            # Its plans were being looked for.
            events, intentions = [event], iter(())
        for intention in intentions:
            means = intention.top
            place = means.place
            what = f"{means.plan.plan.trigger}: {message}"
            return Problem(place.file, place.line, place.column, what)
        for event in events:
            for plan in self.plans.candidates(event.sort, event.literal):
                place = plan.plan.place
                what = f"{plan.plan.trigger}: {message}"
                return Problem(place.file, place.line, place.column, what)
        return Problem(self.program.source, 0, 0, message)

    def _cycle(self) -> None:
        circumstance = self.circumstance
        self.logic.begin_cycle()
        circumstance.selected_event = circumstance.selected = None
        if self.alarms.heap or self._tasks or self._percepts.changed or self._mailbox:
            self._wake_and_sense()
        if circumstance.atomic is None and (circumstance.events or circumstance.atomic_event):
            deliberate(self)
        if circumstance.feedback:
            self._take_feedback()
        intention = circumstance.select()
        circumstance.selected = intention
        if intention is None or not intention.stack:
            return
        means = intention.stack[-1]
        step = means.step
        if step is None:
            self.move_on(intention, means)
        else:
            step.run(self, intention, means, step)
            if means.step is None and intention.stack:
                clear(self, intention)
        if self._requested is not None:
            self._perform(self._requested)

    def _wake_and_sense(self) -> None:
        self.alarms.ring(self.clock)
        while self._tasks:
            self._tasks.popleft()()
        if self._percepts.changed:
            for event in self._percepts.update(self.beliefs):
                self.note("percept", event)
                self.circumstance.post(event)
        if self._mailbox and self.society is not None:
            self.society.process(self, self._mailbox.popleft())

    def _take_feedback(self) -> None:
        circumstance = self.circumstance
        while circumstance.feedback:
            pending, success = circumstance.feedback.popleft()
            intention = pending.intention
            if circumstance.pending_actions.get(intention.number) is not pending:
                continue
            circumstance.take_action(intention)
            if success:
                self.move_on(intention, intention.top)
            else:
                fail(self, intention, error_annots("action_failed", ""))
            return

    def _perform(self, pending: PendingAction) -> None:
        self._requested = None
        self.circumstance.expect(pending)
        self.note("action", pending.action, pending.intention)
        outcome = True if self._act is None else self._act(pending.action)
        if not isinstance(outcome, Pending):
            self.circumstance.feedback.append((pending, bool(outcome)))

    def _note_end(self, intention: Intention) -> None:
        self.note("ended", f"intention {intention.number}", intention)


def _as_literal(value: str | Literal) -> Literal:
    return parse_literal(value) if isinstance(value, str) else value
