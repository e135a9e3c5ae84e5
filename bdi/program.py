"""A program as written: beliefs, rules, goals, plans. Values that know their place in the file.

`str` of any of them is AgentSpeak again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TypeAlias

from .terms import TRUE, Function, Literal, Relation, Term, Var, is_ground, text
from .transform import transformed


@dataclass(frozen=True)
class Place:
    """Where something stands; lines and columns count from 1."""

    file: str = ""
    line: int = 0
    column: int = 0


NOWHERE = Place()


@dataclass(frozen=True)
class Trigger:
    """The event of a plan: an operator (+ or -), a kind ("" belief, "!" goal, "?" test)."""

    operator: str
    kind: str
    literal: Literal | Var

    @property
    def sort(self) -> str:
        """Operator and kind together: `+!`, `-`, `+?` …"""
        return self.operator + self.kind

    def __str__(self) -> str:
        return f"{self.operator}{self.kind}{self.literal}"


# ---- plan bodies


@dataclass(frozen=True)
class Achieve:
    """`!g`: a subgoal; with `new_focus` (`!!g`) a goal of its own."""

    goal: Literal | Var
    new_focus: bool = False
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return f"{'!!' if self.new_focus else '!'}{self.goal}"


@dataclass(frozen=True)
class Test:
    """`?b`: a query, or a subgoal when there is no answer but a `+?b` plan."""

    formula: Term
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return f"?{text(self.formula)}"


@dataclass(frozen=True)
class Update:
    """A change of beliefs; `operator` is one of + +< +> ++ - -- -+."""

    operator: str
    belief: Literal | Var
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return f"{self.operator}{self.belief}"


@dataclass(frozen=True)
class Act:
    """An external or internal action, or a variable that stands for one."""

    action: Literal | Var
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return str(self.action)


@dataclass(frozen=True)
class Constraint:
    """An expression in a body, as `X = Y + 1`: fails when it does not hold."""

    relation: Term
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        if isinstance(self.relation, Relation):
            relation = self.relation
            return f"{text(relation.left)} {relation.symbol} {text(relation.right)}"
        return text(self.relation)


@dataclass(frozen=True)
class If:
    condition: Term
    then: Body
    otherwise: Body
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        tail = f" else {block_text(self.otherwise)}" if self.otherwise else ""
        return f"if ({text(self.condition)}) {block_text(self.then)}{tail}"


@dataclass(frozen=True)
class While:
    condition: Term
    body: Body
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return f"while ({text(self.condition)}) {block_text(self.body)}"


@dataclass(frozen=True)
class For:
    generator: Term
    body: Body
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return f"for ({text(self.generator)}) {block_text(self.body)}"


@dataclass(frozen=True)
class Fork:
    """Branches side by side: `|&|` goes on when all have ended, `|||` when the first has."""

    all_of: bool
    branches: tuple[Body, ...]
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        sign = " |&| " if self.all_of else " ||| "
        return sign.join(
            str(branch[0])
            if len(branch) == 1 and not isinstance(branch[0], Fork | If | While | For)
            else f"({body_text(branch)})"
            for branch in self.branches
        )


BodyFormula: TypeAlias = "Achieve | Test | Update | Act | Constraint | If | While | For | Fork"
Body: TypeAlias = tuple[BodyFormula, ...]


def body_text(body: Body) -> str:
    return "; ".join(map(str, body))


def block_text(body: Body) -> str:
    return f"{{ {body_text(body)} }}" if body else "{ }"


# ---- clauses


class Clause:
    """What a program is made of."""

    @cached_property
    def functions(self) -> frozenset[str]:
        """The names of the functions that it calls.

        A clause is shared by all agents that run it, so they are looked for once.
        """
        found: set[str] = set()

        def look(part: object) -> None:
            if isinstance(part, Function):
                found.add(part.name)

        transformed(self, look)
        return frozenset(found)


@dataclass(frozen=True)
class Rule(Clause):
    """`head :- body`: the head is believed wherever the body holds."""

    head: Literal
    body: Term
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return f"{self.head} :- {text(self.body)}"


@dataclass(frozen=True)
class Plan(Clause):
    """`@label[annotations] trigger : context <- body.`"""

    label: Literal | None
    trigger: Trigger
    context: Term
    body: Body
    place: Place = field(default=NOWHERE, compare=False)

    @property
    def atomic(self) -> bool:
        """Whether nothing else runs while the plan does: its label says `[atomic]`."""
        return self.label is not None and Literal("atomic") in self.label.annots

    @property
    def name(self) -> str:
        """What its label calls it; empty without a label."""
        return "" if self.label is None else self.label.functor

    def __str__(self) -> str:
        label = "" if self.label is None else f"@{self.label} "
        context = "" if self.context == TRUE else f" : {text(self.context)}"
        body = f" <- {body_text(self.body)}" if self.body else ""
        return f"{label}{self.trigger}{context}{body}"


@dataclass(frozen=True)
class Goal(Clause):
    """An initial goal."""

    goal: Literal
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return f"!{self.goal}"


@dataclass(frozen=True)
class Belief(Clause):
    """An initial belief."""

    belief: Literal
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return str(self.belief)


@dataclass(frozen=True)
class Program:
    """What an agent starts with. `folder` is where `.include` may read from, if anywhere."""

    source: str
    beliefs: tuple[Belief | Rule, ...] = ()
    goals: tuple[Goal, ...] = ()
    plans: tuple[Plan, ...] = ()
    folder: Path | None = None

    def __str__(self) -> str:
        clauses = (*self.beliefs, *self.goals, *self.plans)
        return "".join(f"{clause}.\n" for clause in transformed(clauses, _escaped))


def _escaped(part: object) -> str | None:
    """A string as it is written in a program; None for anything else."""
    if not isinstance(part, str):
        return None
    return part.replace('"', '\\"').replace("\n", "\\n")


# ---- plans, bodies and triggers as terms


@dataclass(frozen=True)
class TriggerTerm:
    """`{+!g(X)}` as an argument."""

    kind: str
    literal: Literal | Var

    @property
    def ground(self) -> bool:
        return is_ground(self.literal)

    @property
    def size(self) -> int:
        return self.literal.size

    @property
    def depth(self) -> int:
        return self.literal.depth

    def substituted(self, substitution: Callable[[Term], Term]) -> TriggerTerm:
        literal = substitution(self.literal)
        return TriggerTerm(self.kind, literal) if isinstance(literal, Literal | Var) else self

    def __str__(self) -> str:
        return f"{{ {self.kind}{self.literal} }}"


@dataclass(frozen=True)
class BodyTerm:
    """`{ !g; +b }` as an argument."""

    body: Body
    ground = True
    size = 1
    depth = 1

    def substituted(self, substitution: Callable[[Term], Term]) -> BodyTerm:
        return self

    @property
    def as_trigger(self) -> TriggerTerm | None:
        """`{+b}`, which reads as a body, taken as the event it also stands for."""
        if len(self.body) == 1 and isinstance(self.body[0], Update):
            update = self.body[0]
            if update.operator in ("+", "-"):
                return TriggerTerm(update.operator, update.belief)
        return None

    def __str__(self) -> str:
        return block_text(self.body)


@dataclass(frozen=True)
class PlanTerm:
    """`{ +!g : c <- b }` as an argument."""

    plan: Plan
    ground = True
    size = 1
    depth = 1

    def substituted(self, substitution: Callable[[Term], Term]) -> PlanTerm:
        return self

    def __str__(self) -> str:
        has_more = self.plan.body or self.plan.context != TRUE
        return f"{{ {self.plan} }}" if has_more else f"{{ {self.plan} <- true }}"
