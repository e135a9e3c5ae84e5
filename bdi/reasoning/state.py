"""State of an agent: percepts, loaded programs, and all values that its reasoning shares.

The internal actions that a program calls and its compiled plans are cached per program, so that
agents share them. Each agent has its own library of these plans, and its own beliefs.
"""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count
from random import Random
from typing import Protocol, TypeAlias

from ..actions import InternalAction, check_actions
from ..errors import ProgramError, TooDeepError
from ..language.program import Belief, Plan, Program, Rule, made_once, with_run_functions
from ..language.substitution import Names, Unifier, rename, substitute_literal
from ..language.terms import TRUE, Literal
from ..society import Message, Society
from .beliefs import BeliefBase, LiveBeliefs, with_source
from .circumstance import Circumstance, GoalStates, Perform, Timer, TimerQueue
from .intentions import Event, Intention
from .logic import Answer, Logic
from .plans import PlanLibrary

KINDS = ("percept", "plan", "action", "print", "log", "ended", "warning")
"""Kinds of entries."""


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One event inside an agent, passed to `on_event`.

    Parameters
    ----------
    time : float
        Time in seconds.
    kind : str
        One of percept, plan, action, print, log, ended and warning.
    text : str
        Event, action or message.
    intention : int, optional
        Number of the intention, or 0.
    file : str, optional
        Program file of the current step.
    line : int, optional
        Line in that file, counted from 1, or 0.
    """

    time: float
    kind: str
    text: str
    intention: int = 0
    file: str = ""
    line: int = 0

    def __str__(self) -> str:
        place = f"  ({self.file}:{self.line})" if self.line else ""
        number = f"#{self.intention}" if self.intention else ""
        return f"{self.time:10.3f}  {number:>4}  {self.kind:<8} {self.text}{place}"


@dataclass(frozen=True, kw_only=True)
class AgentSettings:
    """Settings of an agent: seed, start time, live beliefs, reports and limits.

    Parameters
    ----------
    seed : int, optional
        Random seed. If agents of a society have the same seed, the random numbers of all but the
        first also depend on their names.
    start : float, optional
        Start time in seconds. Defaults to the time of the society.
    live : mapping, optional
        Functions that answer queries instead of stored beliefs, by (functor, arity). Each returns
        the argument tuples that hold at the time of the query. These beliefs have the source
        `percept`, raise no events, and are not part of `beliefs`.
    strict : bool, optional
        Reject programs that call unknown internal actions. By default such a call causes a warning,
        and the plan that contains it fails.
    on_event : callable, optional
        Function called with an `Entry` for each internal event, such as the `append` of
        `collections.deque(maxlen=10_000)`.
    kinds : collection of str, optional
        Kinds of entries passed to `on_event`. Defaults to all kinds.
    max_cycles : int, optional
        Maximum number of reasoning cycles at one time.
    max_goals : int, optional
        Maximum number of goals tried in one cycle.
    max_depth : int, optional
        Maximum number of plans in an intention.
    max_intentions : int, optional
        Maximum number of simultaneous intentions.
    """

    seed: int = 0
    start: float | None = None
    live: LiveBeliefs = field(default_factory=dict)
    strict: bool = False
    on_event: Callable[[Entry], None] | None = None
    kinds: Collection[str] = KINDS
    max_cycles: int = 3_000_000
    max_goals: int = 1_000_000
    max_depth: int = 200_000
    max_intentions: int = 20_000


Change: TypeAlias = tuple[bool, Literal]
"""A percept, with True if it is added and False if it is removed."""


class PerceptBuffer:
    """Current percepts, and changes that wait for the next `advance`.

    Attributes
    ----------
    at_once
        True while the agent runs, so that changes apply immediately.
    coming
        Changes that wait for the next `advance`, in order.
    changed
        Percepts changed since the last update of the belief base, by identity, with True if added.
    """

    def __init__(self) -> None:
        self.at_once = False
        self.coming: list[Change] = []
        self.changed: dict[object, Change] = {}
        self._now: dict[object, Literal] = {}

    @property
    def current(self) -> list[Literal]:
        """Current percepts in order of arrival."""
        return list(self._now.values())

    def queue(self, change: Change) -> None:
        """Add or remove a percept, at the next `advance` or immediately."""
        if self.at_once:
            self._change((change,))
        else:
            self.coming.append(change)

    def apply(self) -> None:
        """Apply the queued changes."""
        changes, self.coming = self.coming, []
        self._change(changes)

    def _change(self, changes: Iterable[Change]) -> None:
        now, changed = self._now, self.changed
        for change in changes:
            added, percept = change
            key = percept.identity
            if (key in now) is added:
                continue
            if added:
                now[key] = percept
            else:
                del now[key]
            # The order of changes is the order in time, also for percepts that return.
            if changed:
                changed.pop(key, None)
            changed[key] = change

    def update(self, beliefs: BeliefBase) -> list[tuple[str, Literal]]:
        """Update the beliefs from the percepts. Return the changes, deletions first.

        A current percept is new again after the program has removed its belief.
        """
        changed, self.changed = self.changed, {}
        changes = []
        for is_added, percept in changed.values():
            if not is_added:
                removed = beliefs.forget_percept(percept)
                if removed is not None:
                    changes.append(("-", removed))
        if beliefs.lost_percepts:
            changed = self._with_lost(beliefs, changed)
        for is_added, percept in changed.values():
            if is_added:
                belief = beliefs.perceive(percept)
                if belief is not None:
                    changes.append(("+", belief))
        return changes

    def _with_lost(
        self, beliefs: BeliefBase, changed: dict[object, Change]
    ) -> dict[object, Change]:
        """Return the changes, preceded by the current percepts that lost their beliefs."""
        lost, beliefs.lost_percepts = beliefs.lost_percepts, {}
        keys = {**lost, **changed}
        return {key: (True, self._now[key]) for key in keys if key in self._now}


MILLISECOND = 1_000_000
SECOND = 1_000_000_000

_LOG = logging.getLogger("bdi")


class AnswerReceiver(Protocol):
    """Question of an intention that waits for the answer."""

    def answer(self, message: Message) -> None:
        """Handle an answer."""


Query: TypeAlias = "Callable[[AgentState, Literal, Unifier], Answer]"


def nanoseconds(seconds: float) -> int:
    """Return a time in whole nanoseconds, so that sums are exact.

    Raises `ValueError` if the time is not finite.
    """
    if not math.isfinite(seconds):
        raise ValueError(f"a time must be a finite number of seconds, not {seconds}")
    return round(seconds * SECOND)


class AgentState:
    """State of one agent.

    Attributes
    ----------
    name
        Name of the agent.
    program
        Initial program.
    actions
        Internal actions by name.
    act
        Function that carries out external actions. Without it every action succeeds.
    beliefs
        Belief base.
    plans
        Plan library.
    circumstance
        Events and intentions.
    logic
        Evaluator of queries over the beliefs.
    names
        Source of fresh variables.
    percepts
        Percepts.
    mailbox
        Unread messages.
    questions
        Questions whose answers are awaited, by number.
    society
        Agents that can exchange messages with this one.
    functions
        Arithmetic functions that depend on the run, by name.
    known_programs
        Names of programs loaded on demand.
    sleeps
        True if the agent is idle and its plans for that were called.
    alarms
        Timers.
    tasks
        Tasks for the beginning of the next cycle.
    clock
        Time (ns).
    now
        The same time (s), as given by the caller.
    max_depth
        Maximum number of plans in an intention.
    strict
        True to reject programs that call unknown internal actions.
    is_stopped
        True if the program has ended itself.
    is_observed
        True if percepts, plans or actions are reported by `note`.
    """

    def __init__(
        self,
        program: Program,
        name: str,
        query: Query,
        *,
        actions: Mapping[str, InternalAction],
        functions: Mapping[str, Callable[..., float]],
        act: Perform | None,
        print: Callable[[str], None] | None,
        society: Society,
        settings: AgentSettings,
    ) -> None:
        start = society.now if settings.start is None else settings.start
        self.name = name
        self.program = program
        self.actions = actions
        self.strict = settings.strict
        self.act = act
        self.names = Names()
        self.beliefs = BeliefBase(settings.live)
        self.plans = PlanLibrary()
        self.circumstance = Circumstance()
        self.logic = Logic(
            self.beliefs, self.names, lambda a, u: query(self, a, u), settings.max_goals
        )
        self.percepts = PerceptBuffer()
        self.mailbox: deque[Message] = deque()
        self.questions: dict[int, AnswerReceiver] = {}
        self.society = society
        self.sleeps = False
        self.alarms = TimerQueue()
        self.tasks: deque[Callable[[], None]] = deque()
        self._seed = society.own_seed(name, settings.seed)
        self.clock = nanoseconds(start)
        self.now = float(start)
        self.max_depth = settings.max_depth
        self.is_stopped = False
        self._noted = frozenset() if settings.on_event is None else frozenset(settings.kinds)
        self.is_observed = not self._noted.isdisjoint(("percept", "plan", "action"))
        self._max_intentions = settings.max_intentions
        self._print = print
        self._on_event = settings.on_event
        self.known_programs: set[str] = set()
        self.functions: dict[str, Callable[..., float]] = {
            "math.random": lambda limit=1.0: self.random.random() * limit,
            "system.time": lambda: float(self.clock // MILLISECOND),
            ".count": lambda formula, u: float(sum(1 for _ in self.logic.solutions(formula, u))),
            **functions,
        }
        self._intention_numbers = count(1)
        self._action_numbers = count(1)
        if "ended" in self._noted:
            self.circumstance.on_end = self._note_end

    @cached_property
    def random(self) -> Random:
        """Random number generator, created on first use."""
        return Random(self._seed)

    # ---- beliefs

    def believe(self, literal: Literal) -> None:
        """Add a belief, by default with the source `self`, and raise its event."""
        self.add_belief(with_source(literal))

    def add_belief(self, literal: Literal, *, at_end: bool = False) -> None:
        """Add a belief with its annotations, and raise its event."""
        added = self.beliefs.add(literal, at_end=at_end)
        if added is not None:
            self.circumstance.post(Event("+", added))

    def disbelieve(self, literal: Literal) -> None:
        """Remove a belief, by default that of the source `self`, and raise its event."""
        removed = self.beliefs.remove(with_source(literal), {})
        if removed is not None:
            self.circumstance.post(Event("-", removed))

    def abolish(self, literal: Literal) -> None:
        """Remove a belief from all sources. Its event has no annotations."""
        removed = self.beliefs.remove(literal, {})
        if removed is not None:
            self.circumstance.post(Event("-", removed.without_annots()))

    def changed(self, sort: str, literal: Literal, intention: Intention | None) -> bool:
        """Raise the event of a belief change, or return False if the event would have no effect.

        That is the case if the next cycle would take the event and discard it: no plan is relevant,
        nothing waits for it, and nothing precedes it. Skipping the event then saves a cycle.
        """
        if not self.plans.candidates(sort, literal) and self.is_quiet:
            return False
        self.circumstance.post(Event(sort, literal, intention))
        return True

    def swapped(self, removed: Literal, added: Literal, intention: Intention) -> bool:
        """Raise the events of a replaced belief. Return as `changed`."""
        candidates = self.plans.candidates
        if candidates("-", removed) or candidates("+", added) or not self.is_quiet:
            self.changed("-", removed, None)
            return self.changed("+", added, intention)
        return False

    @property
    def is_quiet(self) -> bool:
        """True if the next cycle would begin without new input or events."""
        circumstance = self.circumstance
        return not (
            circumstance.events
            or self.percepts.changed
            or circumstance.waits
            or circumstance.atomic is not None
            or circumstance.atomic_event is not None
            or self.tasks
            or self.mailbox
            or (self.alarms.heap and self.alarms.is_due(self.clock))
            or circumstance.has_conditions
            or self.plans.has_special
        )

    # ---- actions and intentions

    def next_action_number(self) -> int:
        """Return an unused number for an external action."""
        return next(self._action_numbers)

    def next_intention_number(self) -> int:
        """Return an unused number for an intention.

        Raises `TooDeepError` if the maximum number of intentions exists.
        """
        of = self.circumstance
        if len(of.running) + len(of.pending) + len(of.pending_actions) >= self._max_intentions:
            raise TooDeepError(f"more than {self._max_intentions:,} intentions at once")
        return next(self._intention_numbers)

    def after(self, milliseconds: int, task: Callable[[], None]) -> Timer:
        """Schedule `task` after a time (ms)."""
        return self.alarms.set(self.clock + milliseconds * MILLISECOND, task)

    def stop(self) -> None:
        """End the program."""
        self.is_stopped = True
        self.circumstance.clear_intentions()
        self.circumstance.clear_events()
        self.alarms.clear()
        self.tasks.clear()

    # ---- reports

    def say(self, line: str) -> None:
        """Print a line, as `.print` does."""
        self.note("print", line)
        if self._print is None:
            print(line)
        else:
            self._print(line)

    def warn(self, line: str, intention: Intention | None = None) -> None:
        """Log a warning caused by `intention`, and report it to `on_event`."""
        _LOG.warning("%s: %s", self.name, line)
        self.note("warning", line, intention)

    def note(self, kind: str, content: object, intention: Intention | None = None) -> None:
        """Report an entry to `on_event`."""
        if self._on_event is None or kind not in self._noted:
            return
        number = 0 if intention is None else intention.number
        file, line = "", 0
        if intention is not None and intention.stack:
            place = intention.top.place
            file, line = place.file, place.line
        entry = Entry(
            time=self.now, kind=kind, text=str(content), intention=number, file=file, line=line
        )
        self._on_event(entry)

    def _note_end(self, intention: Intention) -> None:
        self.note("ended", f"intention {intention.number}", intention)


def start(agent: AgentState, beliefs: Sequence[Belief] = ()) -> None:
    """Load the initial program of an agent. `beliefs` precede those of the program.

    Raises `ProgramError` for internal actions that are not allowed, and for labels used twice.
    """
    program = agent.program
    _check(agent, program)
    if _functions_of_plans(program).isdisjoint(agent.functions):
        agent.plans.take(_library(program))
    else:
        _file(with_run_functions(program.plans, agent.functions), agent.plans)
    _note_plans(agent)
    _begin(agent, program, beliefs)


def add_program(agent: AgentState, program: Program) -> None:
    """Add plans after the existing ones, then beliefs and goals, which raise events.

    Raises `ProgramError` for internal actions that are not allowed, and for labels used twice.
    """
    _check(agent, program)
    _file(with_run_functions(program.plans, agent.functions), agent.plans)
    _note_plans(agent)
    _begin(agent, program)


def add_plan(agent: AgentState, plan: Plan, source: Literal, *, first: bool = False) -> None:
    """Add one plan while the agent runs.

    Raises `ProgramError` for internal actions that are not allowed, and `ValueError` if another
    plan has its label.
    """
    whole = Program(source=agent.program.source, plans=(plan,))
    _check(agent, whole)
    (bound,) = with_run_functions(whole.plans, agent.functions)
    agent.plans.add(bound, source, first=first)
    _note_plans(agent)


def _check(agent: AgentState, program: Program) -> None:
    """Check the internal actions of a program, with a warning for each that does not exist."""
    actions = {**agent.actions, **agent.functions}
    for problem in check_actions(program, actions, strict=agent.strict):
        agent.warn(f"{problem} (plans that call it fail)")


def learn(agent: AgentState, program: Program) -> None:
    """Add the plans of a program on first use."""
    if program.source not in agent.known_programs:
        agent.known_programs.add(program.source)
        add_program(agent, program)


@made_once
def _functions_of_plans(program: Program) -> frozenset[str]:
    """Return the names of the arithmetic functions that the plans of a program call."""
    return frozenset[str]().union(*(plan.functions for plan in program.plans))


@made_once
def _library(program: Program) -> PlanLibrary:
    """Return the compiled plans of a program."""
    library = PlanLibrary()
    _file(program.plans, library)
    return library


def _file(plans: Sequence[Plan], library: PlanLibrary) -> None:
    for plan in plans:
        try:
            library.add(plan)
        except ValueError as error:
            raise ProgramError([plan.place.problem(str(error))]) from None


@made_once
def _believed(program: Program) -> tuple[Belief | Rule, ...]:
    """Return the beliefs and rules of a program, rules with a source."""
    return tuple(
        Rule(with_source(one.head), one.body, one.place) if isinstance(one, Rule) else one
        for one in program.beliefs
    )


def _note_plans(agent: AgentState) -> None:
    """Record goal states if any plan uses them."""
    if agent.plans.has_states and agent.circumstance.states is None:
        agent.circumstance.states = GoalStates(agent.circumstance, agent.plans)


def _begin(agent: AgentState, program: Program, beliefs: Sequence[Belief] = ()) -> None:
    """Add the beliefs and goals of a program."""
    clauses = with_run_functions((*beliefs, *_believed(program)), agent.functions)
    # Each belief is added at the front, so they are added in reverse order.
    for clause in reversed(clauses):
        _believe(agent, clause)
    for goal in program.goals:
        literal = rename(with_source(goal.goal), agent.names, {})
        agent.circumstance.post(Event("+!", literal))


def _believe(agent: AgentState, clause: Belief | Rule) -> None:
    if isinstance(clause, Rule):
        agent.beliefs.add_rule(clause)
        return
    literal = clause.belief
    if not literal.ground:
        literal = substitute_literal(literal, {})
    if literal.ground:
        agent.believe(literal)
    else:
        agent.beliefs.add_rule(Rule(with_source(literal), TRUE, clause.place))
