"""State of an agent: all that the reasoning cycle, its steps and internal actions work on."""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Callable, Collection, Mapping
from functools import cached_property
from itertools import count
from random import Random
from typing import Protocol, TypeAlias

from ..errors import TooDeepError
from ..language.program import Program
from ..language.substitution import Names, Unifier
from ..language.terms import Literal
from .actions import InternalAction
from .alarms import Alarm, Alarms
from .beliefs import BeliefBase, LiveBeliefs, with_source
from .circumstance import Circumstance, Perform
from .history import Entry
from .intentions import Event, Intention
from .logic import Answer, Logic
from .percepts import Percepts
from .plans import PlanLibrary
from .society import Message, Society

MILLISECOND = 1_000_000
SECOND = 1_000_000_000

_LOG = logging.getLogger("bdi")


class Question(Protocol):
    """Question whose answer an intention waits for."""

    def answer(self, message: Message) -> None:
        """Take an answer."""


Query: TypeAlias = "Callable[[AgentState, Literal, Unifier], Answer]"


def nanoseconds(seconds: float) -> int:
    """Return a time in whole nanoseconds, in which times add up exactly: 0.1 + 0.2 is 0.3.

    Raises:
        ValueError: the time is not finite.
    """
    if not math.isfinite(seconds):
        raise ValueError(f"a time is a number of seconds, not {seconds}")
    return round(seconds * SECOND)


class AgentState:
    """State of one agent.

    Attributes:
        name: name of the agent.
        program: the program it started with.
        actions: its internal actions by name.
        act: carries out an external action; without it every action succeeds.
        beliefs: its belief base.
        plans: its plan library.
        circumstance: its events and intentions.
        logic: answers queries over its beliefs.
        names: source of fresh variables.
        percepts: what it perceives.
        mailbox: messages it has not read.
        questions: by its number, the question whose answer is waited for.
        society: the agents it can send messages to; itself alone if it belongs to no other.
        functions: its arithmetic functions that belong to the run, by name.
        known_programs: names of the programs that it has learnt when it needed them.
        sleeps: True if it has nothing to do and its plans for that have been called.
        alarms: tasks for later times.
        tasks: tasks for the beginning of the next cycle.
        clock: time (ns).
        now: the same time (s), as the caller gave it.
        max_depth: largest number of plans in an intention.
        strict: True to refuse programs that call internal actions that do not exist.
        is_stopped: True when the program has ended itself.
        is_observed: True if somebody is told of percepts, plans or actions (`note`).
    """

    def __init__(
        self,
        program: Program,
        name: str,
        query: Query,
        *,
        actions: Mapping[str, InternalAction],
        strict: bool,
        live: LiveBeliefs,
        seed: int | str,
        start: float,
        act: Perform | None,
        print: Callable[[str], None] | None,
        on_event: Callable[[Entry], None] | None,
        kinds: Collection[str],
        society: Society | None,
        functions: Mapping[str, Callable[..., float]] | None,
        max_goals: int,
        max_depth: int,
        max_intentions: int,
    ) -> None:
        self.name = name
        self.program = program
        self.actions = actions
        self.strict = strict
        self.act = act
        self.names = Names()
        self.beliefs = BeliefBase(live)
        self.plans = PlanLibrary()
        self.circumstance = Circumstance()
        self.logic = Logic(self.beliefs, self.names, lambda a, u: query(self, a, u), max_goals)
        self.percepts = Percepts()
        self.mailbox: deque[Message] = deque()
        self.questions: dict[int, Question] = {}
        self.society = society
        self.sleeps = False
        self.alarms = Alarms()
        self.tasks: deque[Callable[[], None]] = deque()
        self._seed = seed
        self.clock = nanoseconds(start)
        self.now = float(start)
        self.max_depth = max_depth
        self.is_stopped = False
        self._noted = frozenset() if on_event is None else frozenset(kinds)
        self.is_observed = not self._noted.isdisjoint(("percept", "plan", "action"))
        self._max_intentions = max_intentions
        self._print = print
        self._on_event = on_event
        self.known_programs: set[str] = set()
        self.functions: dict[str, Callable[..., float]] = {
            "math.random": lambda limit=1.0: self.random.random() * limit,
            "system.time": lambda: float(self.clock // MILLISECOND),
            ".count": lambda formula, u: float(sum(1 for _ in self.logic.solutions(formula, u))),
            **(functions or {}),
        }
        self._intention_numbers = count(1)
        self._action_numbers = count(1)
        if "ended" in self._noted:
            self.circumstance.on_end = self._note_end

    @cached_property
    def random(self) -> Random:
        """Its random numbers, of which most agents draw none."""
        return Random(self._seed)

    # ---- beliefs

    def believe(self, literal: Literal) -> None:
        """Add a belief, with source `self` if it names none, and raise its event."""
        self.add_belief(with_source(literal))

    def add_belief(self, literal: Literal, *, at_end: bool = False) -> None:
        """Add a belief with the annotations that it has, and raise its event."""
        added = self.beliefs.add(literal, at_end=at_end)
        if added is not None:
            self.circumstance.post(Event("+", added))

    def disbelieve(self, literal: Literal) -> None:
        """Remove a belief, that of source `self` if it names none, and raise the event."""
        removed = self.beliefs.remove(with_source(literal), {})
        if removed is not None:
            self.circumstance.post(Event("-", removed))

    def abolish(self, literal: Literal) -> None:
        """Remove a belief from whatever sources; its event has no annotations."""
        removed = self.beliefs.remove(literal, {})
        if removed is not None:
            self.circumstance.post(Event("-", removed.without_annots()))

    def changed(self, sort: str, literal: Literal, intention: Intention | None) -> bool:
        """Raise the event of a change of belief; return False if the intention can just continue.

        That is so if the event would be the next one taken and be discarded: no plan is relevant,
        nobody waits for it, and nothing else is to be dealt with before. Leaving it out then saves
        a cycle and changes nothing else.
        """
        if not self.plans.candidates(sort, literal) and self.is_quiet:
            return False
        self.circumstance.post(Event(sort, literal, intention))
        return True

    def swapped(self, removed: Literal, added: Literal, intention: Intention) -> bool:
        """Raise the events of a belief that has taken another's place; return as `changed`."""
        candidates = self.plans.candidates
        if candidates("-", removed) or candidates("+", added) or not self.is_quiet:
            self.changed("-", removed, None)
            return self.changed("+", added, intention)
        return False

    @property
    def is_quiet(self) -> bool:
        """True if the next cycle would begin with nothing new, and no event is to be taken."""
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
        """Return a number that no external action of this agent has yet."""
        return next(self._action_numbers)

    def next_intention_number(self) -> int:
        """Return a number that no intention of this agent has yet.

        Raises:
            TooDeepError: there are as many intentions as are allowed.
        """
        of = self.circumstance
        if len(of.running) + len(of.pending) + len(of.pending_actions) >= self._max_intentions:
            raise TooDeepError(f"more than {self._max_intentions:,} intentions at once")
        return next(self._intention_numbers)

    def after(self, milliseconds: int, task: Callable[[], None]) -> Alarm:
        """Have `task` run after a time."""
        return self.alarms.set(self.clock + milliseconds * MILLISECOND, task)

    def stop(self) -> None:
        """End the program: nothing runs any more."""
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
        """Log a warning, which an `intention` has caused, and report it to `on_event`."""
        _LOG.warning("%s: %s", self.name, line)
        self.note("warning", line, intention)

    def note(self, kind: str, what: object, intention: Intention | None = None) -> None:
        """Report something to `on_event`."""
        if self._on_event is None or kind not in self._noted:
            return
        number = 0 if intention is None else intention.number
        file, line = "", 0
        if intention is not None and intention.stack:
            place = intention.top.place
            file, line = place.file, place.line
        self._on_event(Entry(self.now, kind, str(what), number, file, line))

    def _note_end(self, intention: Intention) -> None:
        self.note("ended", f"intention {intention.number}", intention)
