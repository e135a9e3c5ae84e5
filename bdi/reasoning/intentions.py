"""Events, and intentions: stacks of plans."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Protocol

from ..language.body import Place
from ..language.program import Trigger
from ..language.substitution import Unifier, substitute, substitute_literal
from ..language.terms import Literal, Term, Var, text
from ..language.unification import try_unify
from .plans import BodyStep, LoadedPlan


class Event:
    """Change of a belief or a goal. `intention` waits until it has been handled.

    `option` is a plan that has already been chosen for it, with the bindings.
    """

    __slots__ = ("intention", "literal", "option", "sort")

    def __init__(self, sort: str, literal: Literal, intention: Intention | None = None) -> None:
        self.sort = sort
        self.literal = literal
        self.intention = intention
        self.option: tuple[LoadedPlan, Unifier] | None = None

    @property
    def is_goal(self) -> bool:
        """Whether it is the event of a goal: `+!g`, `-!g`, `+?g` or `-?g`."""
        return len(self.sort) == 2 and self.sort[0] != "^"

    def is_for(self, goal: Literal | Var, u: Unifier) -> bool:
        """Return whether the event unifies with `+!goal`, with bindings in `u`."""
        if self.sort != "+!":
            return False
        literal = self.literal
        if self.intention is not None and self.intention.stack:
            literal = substitute_literal(literal, self.intention.top.u)
        return try_unify(goal, literal, u)

    def __str__(self) -> str:
        return f"{self.sort}{self.literal}"


class Wait(Protocol):
    """Wait of an intention for an event or a condition."""

    def notice(self, event: Event | None) -> None:
        """Check if an event, or another change, ends the wait."""

    def cancel(self) -> None:
        """End the wait of an intention that has ended."""


class Means:
    """Plan of an intention (intended means), with its next step and its unifier.

    Attributes
    ----------
    awaited
        Variables of the last raised event, which the plan above may bind.
    loops
        For each enclosing loop, the unifier before it and its remaining solutions.
    first
        Bindings at the start, which the subplans share.
    """

    __slots__ = ("awaited", "first", "literal", "loops", "plan", "sort", "step", "u")

    def __init__(
        self, plan: LoadedPlan, sort: str, literal: Literal, u: Unifier, step: BodyStep | None
    ) -> None:
        self.plan = plan
        self.sort = sort
        self.literal = literal
        self.u = u
        self.step = step
        self.awaited: tuple[str, ...] = ()
        self.loops: tuple[tuple[Unifier, Iterator[Unifier]], ...] = ()
        # Only subplans need the initial bindings.
        self.first: Unifier = u if plan.inner is None else dict(u)

    @property
    def is_goal(self) -> bool:
        """Whether the plan handles the event of a goal."""
        return len(self.sort) == 2 and self.sort[0] != "^"

    @property
    def trigger(self) -> Trigger:
        """Event for which the plan was chosen."""
        return Trigger(self.sort[0], self.sort[1:], self.literal)

    @property
    def place(self) -> Place:
        """Position in the program of the next step, or of the plan after the last one."""
        return self.plan.plan.place if self.step is None else self.step.formula.place

    @property
    def doing(self) -> str:
        """Text of the next step with its values, or empty after the last one."""
        return "" if self.step is None else text(substitute(self.step.term, self.u))

    def branch(self) -> Means:
        """Return an independent copy."""
        copy = Means(self.plan, self.sort, self.literal, dict(self.u), self.step)
        copy.awaited = self.awaited
        copy.loops = self.loops
        copy.first = self.first
        return copy


class IntentionFork:
    """Branches of an intention, `whole`, which may be a branch of an outer fork."""

    def __init__(self, all_of: bool, whole: Intention) -> None:
        self.all_of = all_of
        self.outer = whole.fork
        self.outer_point = whole.fork_point
        self.branches: list[Intention] = []
        self.to_finish = 0
        self._whole = whole

    def add(self, intention: Intention) -> None:
        """Add a branch."""
        self.branches.append(intention)
        self.to_finish += 1

    def take_place(self) -> None:
        """Replace the whole by the branches in the outer forks."""
        for fork in self._around():
            if self._whole in fork.branches:
                at = fork.branches.index(self._whole)
                fork.branches[at : at + 1] = self.branches

    def remove(self, intention: Intention) -> None:
        """Remove a branch from this fork and the outer forks."""
        for fork in (self, *self._around()):
            if intention in fork.branches:
                fork.branches.remove(intention)

    def _around(self) -> Iterator[IntentionFork]:
        fork = self.outer
        while fork is not None:
            yield fork
            fork = fork.outer


class Intention:
    """Stack of the plans that one event has led to, the active plan last.

    Attributes
    ----------
    number
        Number of the intention, from 1.
    stack
        Plans.
    atomic
        Number of atomic plans in the stack.
    is_suspended
        True between `.suspend` and `.resume`.
    in_line
        True while the intention is queued to run.
    reason
        Cause of its suspension, or the action it waits for.
    wait
        Active `.wait`, if any.
    fork
        Fork of which it is a branch, if any.
    fork_point
        Height of the stack at the fork.
    outer
        Intention for which it handles an event by a subplan.
    """

    __slots__ = (
        *("atomic", "fork", "fork_point", "in_line", "is_suspended", "number", "outer", "reason"),
        *("stack", "wait"),
    )

    def __init__(self, number: int) -> None:
        self.number = number
        self.stack: list[Means] = []
        self.is_suspended = False
        self.in_line = False
        self.reason: Term | None = None
        self.wait: Wait | None = None
        self.fork: IntentionFork | None = None
        self.fork_point = 0
        self.atomic = 0
        self.outer: Intention | None = None

    def __repr__(self) -> str:
        return f"<Intention {self.number}: {' '.join(str(means.trigger) for means in self.stack)}>"

    def push(self, means: Means) -> None:
        """Put a plan on top of the stack."""
        self.stack.append(means)
        if means.plan.atomic:
            self.atomic += 1

    def pop(self) -> Means:
        """Take the plan on top off the stack."""
        means = self.stack.pop()
        if means.plan.atomic:
            self.atomic -= 1
        return means

    @property
    def top(self) -> Means:
        """Active plan."""
        return self.stack[-1]

    @property
    def is_finished(self) -> bool:
        """Whether the stack is empty."""
        return not self.stack

    def downwards(self) -> Iterator[Means]:
        """Iterate over the plans of the stack, the active plan first."""
        return reversed(self.stack)

    def branch(self, number: int, fork: IntentionFork) -> Intention:
        """Return a copy for a branch of a fork, with a copy of the active plan."""
        copy = Intention(number)
        # The plans below the fork are shared, because only one branch continues with them.
        copy.stack = [*self.stack[:-1], self.top.branch()]
        copy.atomic = self.atomic
        copy.fork = fork
        copy.fork_point = len(self.stack)
        return copy

    def wants(self, goal: Literal, u: Unifier) -> bool:
        """Return whether `!goal` is in the stack, with bindings in `u`."""
        return self._position(goal, u) is not None

    def drop_goal(self, goals: Goals, u: Unifier) -> Means | None:
        """Remove the plans of goals and the plans above. Return the lowest one, or None."""
        dropped = None
        position = self._highest(goals, u)
        while position is not None:
            while len(self.stack) > position:
                dropped = self.pop()
            position = self._highest(goals, u)
        # Only the first branch continues below the fork. The others end.
        while dropped is not None and len(self.stack) < self.fork_point:
            if not self._leaves_first():
                self.stack.clear()
                return None
        return dropped

    def _leaves_first(self) -> bool:
        """Leave the fork. Return whether this is its first branch to leave."""
        fork = self.leave_fork()
        first = fork.to_finish > 0
        fork.to_finish = 0
        return first

    def leave_fork(self) -> IntentionFork:
        """Leave the fork for the outer one, and return it."""
        fork = self.fork
        assert fork is not None  # only branches call it
        self.fork, self.fork_point = fork.outer, fork.outer_point
        return fork

    def copy(self, number: int) -> Intention:
        """Return an independent copy."""
        other = Intention(number)
        other.stack = [means.branch() for means in self.stack]
        other.atomic = self.atomic
        return other

    def _position(self, goal: Literal, u: Unifier) -> int | None:
        for position in range(len(self.stack) - 1, -1, -1):
            means = self.stack[position]
            if means.sort == "+!" and try_unify(goal, means.literal, u):
                return position
        return None

    def _highest(self, goals: Goals, u: Unifier) -> int | None:
        for position in range(len(self.stack) - 1, -1, -1):
            if goals.include(self.stack[position], u):
                return position
        return None


class Goals:
    """Goals to finish: those of the plans for which `include` returns True.

    `goal` is the goal with which they unify, if any.
    """

    def __init__(self, include: Callable[[Means, Unifier], bool]) -> None:
        self.include = include
        self.goal: Literal | None = None

    @classmethod
    def of(cls, goal: Literal) -> Goals:
        """Return the goals that unify with `goal`."""
        goals = cls(lambda means, u: means.sort == "+!" and try_unify(goal, means.literal, u))
        goals.goal = goal
        return goals
