"""Programs loaded into agents.

What a program comes to is found out once, however many agents run it: which internal actions it
calls, and its plans compiled and filed. An agent has a library of its own of the plans that it
shares with others, and its own beliefs.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..errors import ProgramError
from ..language.program import Belief, Plan, Program, Rule, made_once, with_run_functions
from ..language.substitution import rename, substitute_literal
from ..language.terms import TRUE, Literal
from .actions import check_actions
from .beliefs import with_source
from .goal_states import GoalStates
from .intentions import Event
from .plans import PlanLibrary
from .state import AgentState


def start(agent: AgentState, beliefs: Sequence[Belief] = ()) -> None:
    """Load the program that an agent starts with; more `beliefs` come before its own.

    Raises:
        ProgramError: it uses internal actions where they are not allowed, or one label twice.
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
    """Add plans after those there are, then beliefs and goals, which raise events.

    Raises:
        ProgramError: it uses internal actions where they are not allowed, or a label that is taken.
    """
    _check(agent, program)
    _file(with_run_functions(program.plans, agent.functions), agent.plans)
    _note_plans(agent)
    _begin(agent, program)


def add_plan(agent: AgentState, plan: Plan, source: Literal, *, first: bool = False) -> None:
    """Add one plan while the agent runs.

    Raises:
        ProgramError: it uses internal actions where they are not allowed.
        ValueError: another plan has its label.
    """
    whole = Program(agent.program.source, plans=(plan,))
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
    """Add the plans of a program that the agent needs, once."""
    if program.source not in agent.known_programs:
        agent.known_programs.add(program.source)
        add_program(agent, program)


@made_once
def _functions_of_plans(program: Program) -> frozenset[str]:
    """Return the names of the arithmetic functions that the plans of a program call."""
    return frozenset[str]().union(*(plan.functions for plan in program.plans))


@made_once
def _library(program: Program) -> PlanLibrary:
    """Return the plans of a program, compiled and filed."""
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
    """Return the beliefs of a program, and its rules as agents believe them: with a source."""
    return tuple(
        Rule(with_source(one.head), one.body, one.place) if isinstance(one, Rule) else one
        for one in program.beliefs
    )


def _note_plans(agent: AgentState) -> None:
    """Take notice of the kinds of plans there are now."""
    if agent.plans.has_states and agent.circumstance.states is None:
        agent.circumstance.states = GoalStates(agent.circumstance, agent.plans)


def _begin(agent: AgentState, program: Program, beliefs: Sequence[Belief] = ()) -> None:
    """Believe what a program believes, and adopt its goals."""
    clauses = with_run_functions((*beliefs, *_believed(program)), agent.functions)
    # Each belief goes to the front, so that the first of them stands first in the end.
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
