"""Intentions: stacks of plans under way, and the events that start them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from .program import Place, Trigger
from .terms import Literal, Term, text
from .unify import Unifier, substitute, unify

if TYPE_CHECKING:
    from .plans import LoadedPlan
    from .steps import Step
    from .waiting import Wait


class Event:
    """Something that happened to beliefs or goals; `intention` waits for it to be dealt with."""

    __slots__ = ("intention", "literal", "sort")

    def __init__(self, sort: str, literal: Literal, intention: Intention | None = None) -> None:
        self.sort = sort
        self.literal = literal
        self.intention = intention

    @property
    def is_goal(self) -> bool:
        return len(self.sort) == 2

    def __str__(self) -> str:
        return f"{self.sort}{self.literal}"


class Means:
    """One plan of an intention: where it is in its body, and what its variables stand for.

    `awaited` names the variables of the event that the plan has raised last
    and that the plan on top of it may bind; `loops` has the unifiers to which
    the loops it is in go back.
    """

    __slots__ = ("awaited", "literal", "loops", "plan", "sort", "step", "u")

    def __init__(
        self, plan: LoadedPlan, sort: str, literal: Literal, u: Unifier, step: Step | None
    ) -> None:
        self.plan = plan
        self.sort = sort
        self.literal = literal
        self.u = u
        self.step = step
        self.awaited: tuple[str, ...] = ()
        self.loops: list[tuple[Unifier, Iterator[Unifier]]] = []

    @property
    def is_goal(self) -> bool:
        return len(self.sort) == 2

    @property
    def trigger(self) -> Trigger:
        return Trigger(self.sort[0], self.sort[1:], self.literal)

    @property
    def place(self) -> Place:
        """Where it is in the program."""
        return self.plan.plan.place if self.step is None else self.step.formula.place

    @property
    def doing(self) -> str:
        """The step it is at, with what its variables stand for; "" after the last one."""
        return "" if self.step is None else text(substitute(self.step.term, self.u))

    def branch(self) -> Means:
        """A copy that goes its own way."""
        copy = Means(self.plan, self.sort, self.literal, dict(self.u), self.step)
        copy.awaited = self.awaited
        copy.loops = list(self.loops)
        return copy


class Fork:
    """Intentions that were one and are to be one again: the `whole`, itself in a fork or not."""

    def __init__(self, all_of: bool, whole: Intention) -> None:
        self.all_of = all_of
        self.outer = whole.fork
        self.outer_point = whole.fork_point
        self.branches: list[Intention] = []
        self.to_finish = 0
        self._whole = whole

    def add(self, intention: Intention) -> None:
        self.branches.append(intention)
        self.to_finish += 1

    def take_place(self) -> None:
        """In the forks around, let the branches stand where the whole did."""
        for fork in self._around():
            if self._whole in fork.branches:
                at = fork.branches.index(self._whole)
                fork.branches[at : at + 1] = self.branches

    def remove(self, intention: Intention) -> None:
        """A branch is over, here and in the forks around."""
        for fork in (self, *self._around()):
            if intention in fork.branches:
                fork.branches.remove(intention)

    def _around(self) -> Iterator[Fork]:
        fork = self.outer
        while fork is not None:
            yield fork
            fork = fork.outer


class Intention:
    """A stack of means; the last one is at work. `atomic` counts the atomic plans in it.

    `in_line` is whether it is among those that run, by turns.
    """

    __slots__ = (
        "atomic",
        "fork",
        "fork_point",
        "in_line",
        "is_suspended",
        "number",
        "reason",
        "stack",
        "wait",
    )

    def __init__(self, number: int) -> None:
        self.number = number
        self.stack: list[Means] = []
        self.is_suspended = False
        self.in_line = False
        self.reason: Term | None = None
        self.wait: Wait | None = None
        self.fork: Fork | None = None
        self.fork_point = 0
        self.atomic = 0

    def push(self, means: Means) -> None:
        """Puts a plan to be carried out on top of the stack."""
        self.stack.append(means)
        if means.plan.atomic:
            self.atomic += 1

    def pop(self) -> Means:
        """Takes the plan on top off the stack."""
        means = self.stack.pop()
        if means.plan.atomic:
            self.atomic -= 1
        return means

    @property
    def top(self) -> Means:
        """The plan at work."""
        return self.stack[-1]

    @property
    def is_finished(self) -> bool:
        """Whether nothing is left to do."""
        return not self.stack

    def downwards(self) -> Iterator[Means]:
        """The plans of the stack, the one at work first."""
        return reversed(self.stack)

    def branch(self, number: int, fork: Fork) -> Intention:
        """A copy for one branch of a fork: the plan on top is its own, those below are shared."""
        copy = Intention(number)
        copy.stack = [*self.stack[:-1], self.top.branch()]
        copy.atomic = self.atomic
        copy.fork = fork
        copy.fork_point = len(self.stack)
        return copy

    def wants(self, goal: Literal, u: Unifier) -> bool:
        """Whether `!goal` is somewhere in the stack; binds what that takes in `u`."""
        for means in self.downwards():
            if means.sort == "+!":
                attempt = dict(u)
                if unify(goal, means.literal, attempt):
                    u.update(attempt)
                    return True
        return False

    def drop_goal(self, goal: Literal, u: Unifier) -> Means | None:
        """Cuts the stack off below the lowest `!goal`; the last of these, if there was one."""
        dropped = None
        position = self._position(goal, u)
        while position is not None:
            while len(self.stack) > position:
                dropped = self.pop()
            position = self._position(goal, u)
        while dropped is not None and len(self.stack) < self.fork_point:
            if not self._leaves_first():
                self.stack.clear()
                return None
        return dropped

    def _leaves_first(self) -> bool:
        """Leave the fork for good; whether no other of its branches has done so before."""
        fork = self.leave_fork()
        first = fork.to_finish > 0
        fork.to_finish = 0
        return first

    def leave_fork(self) -> Fork:
        """It is no branch of its fork any more, but one of the fork around, if there is one."""
        fork = self.fork
        assert fork is not None  # nobody else leaves
        self.fork, self.fork_point = fork.outer, fork.outer_point
        return fork

    def _position(self, goal: Literal, u: Unifier) -> int | None:
        for position in range(len(self.stack) - 1, -1, -1):
            means = self.stack[position]
            if means.sort == "+!":
                attempt = dict(u)
                if unify(goal, means.literal, attempt):
                    u.update(attempt)
                    return position
        return None
