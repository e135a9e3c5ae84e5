"""An agent: interface between a program and its environment.

The caller controls time: `advance(t)` runs reasoning cycles until there is nothing left to do at t.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import NoReturn

from .actions import InternalAction
from .errors import ProgramError, ProgramProblem, TooDeepError
from .internal_actions import STANDARD
from .language.loading import parse_literal
from .language.program import Belief, Program
from .language.terms import Literal
from .reasoning.circumstance import Perform
from .reasoning.execution import call_in_query
from .reasoning.intentions import Intention
from .reasoning.state import (
    AgentSettings,
    AgentState,
    add_program as load_program,
    start as start_program,
)
from .reasoning_cycle import ReasoningCycle
from .society import Message, Society


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
    print : callable, optional
        Function called with each line of `.print`. By default lines go to standard output.
    actions : mapping, optional
        Further internal actions by name. See `InternalActions`.
    society : Society, optional
        Agents that can exchange messages with this one. By default an agent can only send messages
        to itself.
    settings : AgentSettings, optional
        Seed, start time, live beliefs, reports and limits.

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
        `settings.strict`, calls an unknown internal action. Also if the text of a belief is
        invalid.
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
        print: Callable[[str], None] | None = None,
        actions: Mapping[str, InternalAction] | None = None,
        society: Society | None = None,
        settings: AgentSettings | None = None,
    ) -> None:
        if not isinstance(program, Program):
            raise TypeError(f"program must be a bdi.Program (see bdi.load), not {program!r}")
        society = Society() if society is None else society
        settings = AgentSettings() if settings is None else settings
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
            functions=getattr(actions, "functions", {}),
            act=act,
            print=print,
            society=society,
            settings=settings,
        )
        self.beliefs = self._state.beliefs
        self.plans = self._state.plans
        self._cycle = ReasoningCycle(self._state, settings.max_cycles)
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
        return {each.number: each.action for each in pending}

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

    # ---- state and program

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
