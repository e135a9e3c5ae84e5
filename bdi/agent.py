"""An agent: beliefs, plans and intentions, and the cycle that brings them together.

The cycle is Jason's: sense (percepts, one message), deliberate (one event),
act (one feedback of an action, one step of one intention). Time belongs to the
caller: `advance(t)` runs cycles until nothing is left to do at t.
"""

from __future__ import annotations

import heapq
import logging
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from itertools import count
from random import Random
from typing import TYPE_CHECKING, TypeAlias

from .beliefs import BeliefBase
from .circumstance import Circumstance, PendingAction
from .errors import EndlessProgramError, Problem, ProgramError
from .failure import ActionError, clear_failed, end, error_annots, fail, fail_event
from .history import Entry
from .intentions import Event, Intention, Means
from .internal_actions import STANDARD, Call, InternalAction
from .loading import check_actions
from .logic import Answer, Logic
from .order import sorted_annots
from .parser import parse_literal
from .plans import LoadedPlan, PlanLibrary
from .program import Belief, Program, Rule
from .steps import Waiting, with_source
from .terms import FROM_PERCEPT, FROM_SELF, TRUE, Literal, text
from .unify import Names, Unifier, rename, substitute, substitute_literal

if TYPE_CHECKING:
    from .society import Message, Society
    from .waiting import Wait


class Pending:
    """What `act` answers when the outcome of an action comes later, by `Agent.finish`."""

    def __repr__(self) -> str:
        return "bdi.PENDING"


PENDING = Pending()

Perform: TypeAlias = "Callable[[Literal], bool | Pending]"

_LOG = logging.getLogger("bdi")
_NANOSECOND = 1e9


def _clock(seconds: float) -> int:
    return round(seconds * _NANOSECOND)


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
        actions: further internal actions, by name (see `InternalActions`).
        society: the agents it can send messages to.
        max_cycles: how many cycles one instant may take before the agent is stopped.
        max_depth: how many plans an intention may hold.

    Raises:
        ProgramError: the program uses internal actions that do not exist.
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
        actions: Mapping[str, InternalAction] | None = None,
        society: Society | None = None,
        max_cycles: int = 3_000_000,
        max_depth: int = 200_000,
    ) -> None:
        self.program = program
        self.name = name
        self.random = Random(seed)
        self.actions: Mapping[str, InternalAction] = {**STANDARD, **(actions or {})}
        self.names = Names()
        self.beliefs = BeliefBase()
        self.plans = PlanLibrary()
        self.circumstance = Circumstance()
        self.logic = Logic(self.beliefs, self.names, self._call_in_query)
        self.society = society
        self.clock = _clock(start)
        self.max_depth = max_depth
        self._max_cycles = max_cycles
        self._act = act
        self._print = print
        self._on_event = on_event
        self._now = float(start)
        self._begun = False
        self._running = False
        self._stopped = False
        self._percepts: dict[Literal, Literal] = {}
        self._percepts_changed = False
        self._arriving: list[tuple[bool, Literal]] = []
        self._mailbox: deque[Message] = deque()
        self._tasks: deque[Callable[[], None]] = deque()
        self._wakeups: list[tuple[int, int, Callable[[], None], Wait | None]] = []
        self._order = count()
        self._intention_numbers = count(1)
        self._action_numbers = count(1)
        self._requested: PendingAction | None = None
        if on_event is not None:
            self.circumstance.on_end = self._intention_ended
        check_actions(program, self.actions)
        self.add_program(program, [_as_literal(belief) for belief in beliefs])
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
        due = self._next_due()
        return None if due is None else due / _NANOSECOND

    @property
    def intentions(self) -> list[Intention]:
        """What the agent is up to: each intention a stack of plans, the last one at work."""
        return list(self.circumstance.intentions())

    @property
    def percepts(self) -> list[Literal]:
        return list(self._percepts.values())

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
        """Something is perceived from the time of the next `advance` on."""
        self._arrive(True, _as_literal(percept))

    def remove_percept(self, percept: str | Literal) -> None:
        """Something is no longer perceived from the time of the next `advance` on."""
        self._arrive(False, _as_literal(percept))

    def finish(self, action: int | str | Literal, success: bool = True) -> None:
        """Tells the outcome of an action that `act` left PENDING.

        Args:
            action: its number (see `pending_actions`) or the action itself.
            success: whether it was done; its plan fails when it was not.

        Raises:
            ValueError: no such action is open.
        """
        wanted = action if isinstance(action, int) else _as_literal(action)
        for pending in self.circumstance.pending_actions.values():
            if wanted in (pending.number, pending.action):
                self.circumstance.feedback.append((pending, success))
                return
        raise ValueError(f"no action {action} is waiting for its outcome")

    def advance(self, time: float) -> None:
        """Runs until nothing is left to do at `time`, in seconds.

        What was to wake up before is woken at its own time, in order. Percepts
        and outcomes that came since the last call count at `time`.

        Raises:
            ValueError: the time is before `now`.
            EndlessProgramError: a plan goes on for ever at one instant.
        """
        target = _clock(time)
        if target < self.clock:
            raise ValueError(f"time goes forward: {time} s comes before {self._now} s")
        if (
            self._begun
            and not self._arriving
            and not self._wakeups
            and not self._mailbox
            and not self.circumstance.feedback
        ):
            self.clock, self._now = target, time
            return
        self._running = True
        try:
            if not self._begun:
                self._begun = True
                self._run_instant()
            due = self._next_due()
            while due is not None and due < target:
                self.clock, self._now = due, due / _NANOSECOND
                self._run_instant()
                due = self._next_due()
            self.clock, self._now = target, time
            arriving, self._arriving = self._arriving, []
            for added, percept in arriving:
                self._perceive(added, percept)
            self._run_instant()
        except RecursionError:
            problem = Problem(self.program.source, 0, 0, "a term is nested too deeply")
            raise EndlessProgramError([problem]) from None
        finally:
            self._running = False

    # ---- loading

    def add_program(self, program: Program, beliefs: Iterable[Literal] = ()) -> None:
        """Adds plans after those there are, then beliefs and goals, which raise events."""
        for plan in program.plans:
            try:
                self.plans.add(plan)
            except ValueError as error:
                place = plan.place
                problem = Problem(place.file, place.line, place.column, str(error))
                raise ProgramError([problem]) from None
        first = [Belief(belief) for belief in beliefs]
        for clause in reversed([*first, *program.beliefs]):
            self._add_initial(clause)
        for goal in program.goals:
            literal = rename(goal.goal, self.names, {})
            self.circumstance.post(Event("+!", with_source(literal)))  # type: ignore[arg-type]

    def _add_initial(self, clause: Belief | Rule) -> None:
        if isinstance(clause, Rule):
            self.beliefs.add_rule(Rule(with_source(clause.head), clause.body, clause.place))
            return
        literal = substitute_literal(clause.belief, {})
        if not literal.ground:
            self.beliefs.add_rule(Rule(with_source(literal), TRUE, clause.place))
            return
        self.believe(literal)

    # ---- what plans and internal actions do

    def believe(self, literal: Literal) -> None:
        """Adds a belief, from the agent itself when it names no source, and raises its event."""
        added = self.beliefs.add(with_source(literal))
        if added is not None:
            self.circumstance.post(Event("+", added))

    def disbelieve(self, literal: Literal) -> None:
        removed = self.beliefs.remove(with_source(literal), {})
        if removed is not None:
            self.circumstance.post(Event("-", removed))

    def say(self, line: str) -> None:
        """What `.print` does."""
        if self._on_event is not None:
            self._on_event(Entry(self._now, "print", line))
        if self._print is None:
            print(line)
        else:
            self._print(line)

    def warn(self, line: str, intention: Intention | None = None) -> None:
        _LOG.warning("%s: %s", self.name, line)
        self.note("warning", line, intention)

    def note(self, kind: str, line: str, intention: Intention | None = None) -> None:
        """Tells `on_event` of something."""
        if self._on_event is None:
            return
        number = 0 if intention is None else intention.number
        file, row = "", 0
        if intention is not None and intention.stack:
            means = intention.top
            place = means.plan.plan.place if means.step is None else means.step.formula.place
            file, row = place.file, place.line
        self._on_event(Entry(self._now, kind, line, number, file, row))

    def stop(self) -> None:
        """Ends the program: nothing runs any more."""
        self._stopped = True
        self.circumstance.clear_intentions()
        self.circumstance.clear_events()
        self._wakeups.clear()
        self._tasks.clear()

    def at_next_cycle(self, task: Callable[[], None]) -> None:
        self._tasks.append(task)

    def wake_at(self, clock: int, task: Callable[[], None], wait: Wait | None = None) -> None:
        """Runs a task at a time in nanoseconds; of two at the same time the first goes first."""
        heapq.heappush(self._wakeups, (clock, next(self._order), task, wait))

    def next_intention_number(self) -> int:
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
            or self._percepts_changed
            or (self._wakeups and self._wakeups[0][0] <= self.clock)
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
                self.clear(intention)
            return
        if means.step is None:
            self.clear(intention)
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
        self._mailbox.append(message)

    # ---- percepts

    def _arrive(self, added: bool, percept: Literal) -> None:
        if self._running:
            self._perceive(added, percept)
        else:
            self._arriving.append((added, percept))

    def _perceive(self, added: bool, percept: Literal) -> None:
        key = percept.without_annots()
        if added:
            self._percepts.setdefault(key, percept)
        else:
            self._percepts.pop(key, None)
        self._percepts_changed = True

    def _sense(self) -> None:
        """Makes beliefs of what is perceived: first what is gone, then what is new."""
        self._percepts_changed = False
        known = self.beliefs.percepts
        for key in [key for key in known if key not in self._percepts]:
            belief = Literal(key.functor, key.args, (FROM_PERCEPT,), key.negated)
            if self.beliefs.remove(belief, {}) is not None:
                self.note("percept", f"-{key}")
                self.circumstance.post(Event("-", belief))
        for key, percept in self._percepts.items():
            if key not in known:
                annots = sorted_annots((*percept.annots, FROM_PERCEPT))
                added = self.beliefs.add(percept.with_annots(annots))
                if added is not None:
                    self.note("percept", f"+{key}")
                    self.circumstance.post(Event("+", added))

    # ---- time

    def _next_due(self) -> int | None:
        while self._wakeups and self._wakeups[0][3] is not None and self._wakeups[0][3].is_over:
            heapq.heappop(self._wakeups)
        return self._wakeups[0][0] if self._wakeups else None

    def _run_instant(self) -> None:
        cycles = 0
        while self._has_work():
            cycles += 1
            if cycles > self._max_cycles:
                raise EndlessProgramError([self._endless()])
            self._cycle()

    def _has_work(self) -> bool:
        circumstance = self.circumstance
        if self._percepts_changed or self._tasks or self._mailbox:
            return True
        if self._wakeups and self._wakeups[0][0] <= self.clock:
            return True
        if circumstance.feedback and circumstance.has_feedback():
            return True
        if circumstance.atomic is not None:
            return not circumstance.atomic_waits
        return bool(
            circumstance.events or circumstance.running or circumstance.atomic_event is not None
        )

    def _endless(self) -> Problem:
        limit = f"more than {self._max_cycles} cycles at {self._now} s: does a plan never end?"
        for intention in self.circumstance.intentions():
            means = intention.top
            place = means.plan.plan.place if means.step is None else means.step.formula.place
            message = f"{limit} It is in {means.plan.plan.trigger}"
            return Problem(place.file, place.line, place.column, message)
        return Problem(self.program.source, 0, 0, limit)

    # ---- the cycle

    def _cycle(self) -> None:
        circumstance = self.circumstance
        circumstance.selected_event = circumstance.selected = None
        if self._wakeups or self._tasks or self._percepts_changed or self._mailbox:
            self._wake_and_sense()
        if circumstance.atomic is None:
            self._deliberate(circumstance)
        if circumstance.feedback:
            self._take_feedback()
        intention = circumstance.select()
        if intention is None:
            return
        circumstance.selected = intention
        if not intention.stack:
            return
        means = intention.stack[-1]
        step = means.step
        if step is None:
            self.move_on(intention, means)
        else:
            step.run(self, intention, means, step)
            if means.step is None and intention.stack:
                self.clear(intention)
        if self._requested is not None:
            self._perform()

    def _wake_and_sense(self) -> None:
        while self._wakeups and self._wakeups[0][0] <= self.clock:
            heapq.heappop(self._wakeups)[2]()
        while self._tasks:
            self._tasks.popleft()()
        if self._percepts_changed:
            self._sense()
        if self._mailbox and self.society is not None:
            self.society.process(self, self._mailbox.popleft())

    def _deliberate(self, circumstance: Circumstance) -> None:
        """Takes events until one is dealt with; those of beliefs without a plan are discarded."""
        while True:
            event = circumstance.atomic_event
            if event is not None:
                circumstance.atomic_event = None
            elif circumstance.events:
                event = circumstance.events.popleft()
            else:
                return
            circumstance.selected_event = event
            literal = event.literal
            candidates = self.plans.candidates(event.sort, literal)
            for plan in candidates:
                u = plan.match(literal)
                if u is not None and plan.applies is not None:
                    u = plan.applies(self.logic, u)
                if u is not None:
                    self._adopt(plan, event, u)
                    return
            if event.is_goal:
                self._no_plan(event, "applicable" if candidates else "relevant")
                return
            if event.intention is not None:
                # Nobody cares for a change of belief: the plan that made it goes on.
                self.move_on(event.intention, event.intention.top)
                return

    def _adopt(self, plan: LoadedPlan, event: Event, u: Unifier) -> None:
        literal = event.literal
        if not literal.ground:
            literal = substitute_literal(literal, u)
        means = Means(plan, event.sort, literal, u, plan.body)
        intention = event.intention
        if intention is None:
            intention = Intention(next(self._intention_numbers))
        elif intention.stack:
            self._forget_tail(intention, means)
            if len(intention.stack) >= self.max_depth:
                place = plan.plan.place
                message = f"{plan.plan.trigger} calls itself too deeply"
                raise EndlessProgramError([Problem(place.file, place.line, place.column, message)])
        intention.push(means)
        self.circumstance.add_running(intention)
        if self._on_event is not None:
            self.note("plan", f"{event} by {plan}", intention)

    def _forget_tail(self, intention: Intention, means: Means) -> None:
        """A goal that ends by calling one of the same functor leaves no trace."""
        top = intention.top
        if (
            len(top.sort) == 2
            and top.sort[0] == "+"
            and len(means.sort) == 2
            and means.sort[0] == "+"
            and top.step is not None
            and top.step.next is None
            and top.literal.key == means.literal.key
        ):
            intention.pop()
            if intention.stack:
                for name in intention.top.awaited:
                    value = top.u.get(name)
                    if value is not None:
                        means.u[name] = rename(substitute(value, top.u), self.names, {})

    def _no_plan(self, event: Event, what: str) -> None:
        message = f"Found a goal for which there is no {what} plan: {event}"
        fail_event(self, event, error_annots(f"no_{what}", message), message)

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

    def _perform(self) -> None:
        pending = self._requested
        self._requested = None
        if pending is None:
            return
        self.circumstance.expect(pending)
        self.note("action", text(pending.action), pending.intention)
        outcome = True if self._act is None else self._act(pending.action)
        if not isinstance(outcome, Pending):
            self.circumstance.feedback.append((pending, bool(outcome)))

    def clear(self, intention: Intention) -> None:
        """Takes finished plans off an intention and goes on with those that called them."""
        stack = intention.stack
        while stack and stack[-1].step is None:
            top = intention.pop()
            if top.sort[0] == "-" and len(top.sort) == 2 and stack:
                clear_failed(intention, top.literal)
            if not stack:
                break
            means = stack[-1]
            if means.step is not None:
                self._hand_back(means, top.u)
                means.step = means.step.next
        if not stack:
            self.circumstance.remove_running(intention)
            self.circumstance.forget(intention)

    def _hand_back(self, means: Means, u: Unifier) -> None:
        """What a plan has found out for the variables of the one that called it."""
        for name in means.awaited:
            value = u.get(name)
            if value is not None:
                means.u[name] = rename(substitute(value, u), self.names, {})

    def _intention_ended(self, intention: Intention) -> None:
        self.note("ended", f"intention {intention.number}", intention)

    def end_intention(self, intention: Intention) -> None:
        end(self, intention)


def _as_literal(value: str | Literal) -> Literal:
    return parse_literal(value) if isinstance(value, str) else value


__all__ = ["FROM_SELF", "PENDING", "Agent", "Pending"]
