"""An agent: a program that runs, and its environment's side of it.

Time belongs to the caller: `advance(t)` runs reasoning cycles until nothing is left to do at t.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping

from .errors import Problem, ProgramError, TooDeepError
from .internal_actions import STANDARD
from .language.program import Belief, Program
from .language.terms import Literal
from .language.texts import parse_literal
from .reasoning import loading
from .reasoning.actions import InternalAction
from .reasoning.beliefs import LiveBeliefs
from .reasoning.calls import call_in_query
from .reasoning.circumstance import Perform
from .reasoning.cycle import ReasoningCycle
from .reasoning.history import KINDS, Entry
from .reasoning.intentions import Intention
from .reasoning.society import Message, Society
from .reasoning.state import AgentState


class Agent:
    """Runs one program.

    Args:
        program: its beliefs, goals and plans at the start.
        beliefs: more initial beliefs, as text or terms; they come before the program's.
        act: carries out an external action; returns True when it is done, False when it
            failed, or `PENDING` when its outcome comes later, by `finish`. Without it every
            action succeeds.
        name: answer of `.my_name`, and sender of its messages.
        seed: seed of the agent's random numbers. Of the agents of a society with the same seed,
            the first draws from it alone, each other one from it and its name.
        start: time at which it begins (s), by default that of its society.
        print: takes the lines of `.print`. Without it they go to standard output.
        on_event: takes an `Entry` for everything that happens inside, as `History.add` does.
        kinds: the kinds of entries that `on_event` takes; all by default.
        live: beliefs that are asked for and not stored, by functor and arity: each a function
            that returns the arguments of what holds when it is called, as often as a query comes
            to it. They have the source `percept`, raise no events and are not in `beliefs`.
        actions: further internal actions, by name (see `InternalActions`).
        strict: True to refuse a program that calls internal actions that do not exist. Otherwise
            each is a warning, and the plans that call it fail.
        society: the agents it can send messages to; without it it can send to itself alone.
        max_cycles: largest number of cycles at one instant; at more the agent is stopped.
        max_goals: largest number of goals tried in one cycle: by default seconds of work,
            where a handful is usual.
        max_depth: largest number of plans in an intention.
        max_intentions: largest number of intentions at once.

    Attributes:
        name: its name.
        program: the program with which it started.
        actions: its internal actions by name.
        beliefs: its belief base; iterating over it gives the beliefs.
        plans: its plan library.

    Raises:
        ProgramError: the program uses internal actions where they are not allowed, or, if
            `strict`, that do not exist, or one label twice; or a belief that is given as text
            cannot be read.
        TypeError: `program` is none, as where it is the name of a file.
        ValueError: an agent of that name is in the society already.
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
            raise TypeError(f"expected a program, as bdi.load reads one, found {program!r}")
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
            loading.start(self._state, extra)
        except (RecursionError, TooDeepError):
            message = "a formula or a term is nested too deeply"
            raise ProgramError([Problem(program.source, 0, 0, message)]) from None
        society.join(self)

    def __repr__(self) -> str:
        counts = f"{len(self.beliefs)} beliefs, {len(self.intentions)} intentions"
        return f"<Agent {self.name} at {self.now:g} s: {counts}>"

    # ---- time

    @property
    def now(self) -> float:
        """Time up to which it has run (s)."""
        return self._state.now

    @property
    def next_wakeup(self) -> float | None:
        """Time at which it has something to do without anything new from outside (s), or None."""
        return self._cycle.next_wakeup

    def advance(self, time: float) -> None:
        """Run until nothing is left to do at `time`, in seconds.

        Everything due before that is done at its own time, in order. Percepts and outcomes that
        came since the last call count at `time`.

        Args:
            time: the instant up to which it runs (s).

        Raises:
            ValueError: the time is before `now`, or not finite.
            EndlessProgramError: a plan does not end at one instant, or there are too many
                intentions.
        """
        self._cycle.advance(time)

    # ---- percepts, actions and messages

    @property
    def percepts(self) -> list[Literal]:
        """The percepts that hold now, in the order in which they came."""
        return self._state.percepts.current

    def add_percept(self, percept: str | Literal) -> None:
        """Add a percept from the time of the next `advance` on.

        While the agent runs, as in `act`, it is added at once.

        Args:
            percept: a literal, or its text; it is believed with the source `percept`.

        Raises:
            ProgramError: the text is not one literal.
        """
        literal = percept if percept.__class__ is Literal else _as_literal(percept)
        self._state.percepts.notice((True, literal))

    def remove_percept(self, percept: str | Literal) -> None:
        """Remove a percept from the time of the next `advance` on, or at once as `add_percept`.

        Args:
            percept: a literal, or its text; one that is not there makes no difference.

        Raises:
            ProgramError: the text is not one literal.
        """
        literal = percept if percept.__class__ is Literal else _as_literal(percept)
        self._state.percepts.notice((False, literal))

    @property
    def pending_actions(self) -> dict[int, Literal]:
        """The external actions whose outcome is open, by number."""
        pending = self._state.circumstance.pending_actions.values()
        return {one.number: one.action for one in pending}

    def finish(self, action: int | str | Literal, success: bool = True) -> None:
        """Report the outcome of an action for which `act` has returned PENDING.

        Args:
            action: its number (see `pending_actions`) or the action itself.
            success: True if it was done; its plan fails otherwise.

        Raises:
            ValueError: no such action is open.
            ProgramError: the text of the action is not one literal.
        """
        wanted = action if isinstance(action, int) else _as_literal(action)
        if not self._state.circumstance.report(wanted, success):
            raise ValueError(f"no action {action} is waiting for its outcome")

    @property
    def has_mail(self) -> bool:
        """True if it has messages to read."""
        return bool(self._state.mailbox)

    def receive(self, message: Message) -> None:
        """Put a message into the mailbox, from which each cycle reads one."""
        self._state.mailbox.append(message)

    # ---- its mind

    def problem(self, message: str) -> Problem:
        """Return a problem, said in `message`, at the step that it carries out just now.

        So `act` can say where in the program an action stands that makes no sense.
        """
        return self._cycle.problem(message)

    @property
    def intentions(self) -> list[Intention]:
        """Its intentions: each a stack of plans, the one being carried out last."""
        return list(self._state.circumstance.intentions())

    @property
    def is_stopped(self) -> bool:
        """True if the program has ended itself by `.stopMAS`."""
        return self._state.is_stopped

    def add_program(self, program: Program) -> None:
        """Add plans after those there are, then beliefs and goals, which raise events.

        Args:
            program: what it is to believe, want and know besides.

        Raises:
            ProgramError: it uses internal actions where they are not allowed, or, if it is
                strict, that do not exist, or a label that is taken.
        """
        loading.add_program(self._state, program)

    def believe(self, literal: Literal) -> None:
        """Add a belief, with source `self` if it names none, and raise its event."""
        self._state.believe(literal)

    def disbelieve(self, literal: Literal) -> None:
        """Remove a belief, that of source `self` if it names none, and raise the event."""
        self._state.disbelieve(literal)


def _as_literal(value: str | Literal) -> Literal:
    return parse_literal(value) if isinstance(value, str) else value
