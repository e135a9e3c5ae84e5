"""Plan bodies: steps, and traversal and replacement of parts of programs.

`str` of a step is AgentSpeak.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache, cached_property
from types import MappingProxyType
from typing import Any, TypeAlias

from ..errors import ProgramProblem
from .operations import Qualified, Quoted, Relation, TriggerTerm, parts, rebuilt
from .terms import Literal, Term, Var, text


@cache
def _compared_fields(kind: type) -> tuple[str, ...] | None:
    """Return the names of the fields that count in comparisons, or None if it is no dataclass."""
    if not is_dataclass(kind):
        return None
    return tuple(field.name for field in fields(kind) if field.compare)


def transformed(part: Any, change: Callable[[Any], Any]) -> Any:
    """Return a part of a program with all parts replaced for which `change` returns not None.

    The locations in the source are kept.
    """
    changed = change(part)
    if changed is not None:
        return changed

    def inside(inner: Any) -> Any:
        return transformed(inner, change)

    if isinstance(part, tuple):
        return tuple(map(inside, part))
    names = _compared_fields(part.__class__)
    if names is not None:
        return replace(part, **{name: inside(getattr(part, name)) for name in names})
    return rebuilt(part, inside)


def all_parts(part: Any) -> Iterator[Any]:
    """Yield a part of a program and everything inside it, without locations in the source."""
    pending = [part]
    while pending:
        inner = pending.pop()
        yield inner
        if inner.__class__ is tuple:
            pending += inner
            continue
        names = _compared_fields(inner.__class__)
        pending += parts(inner) if names is None else [getattr(inner, name) for name in names]


def has_variables(part: Any) -> bool:
    """Return whether a part of a program contains variables."""
    return any(isinstance(inner, Var) for inner in all_parts(part))


#: Goal, belief or action of a step: a literal or a variable.
Event: TypeAlias = Literal | Var | Qualified


@dataclass(frozen=True)
class Place:
    """Position in a source. Lines and columns count from 1."""

    file: str = ""
    line: int = 0
    column: int = 0

    @property
    def name(self) -> str:
        """Name of the file without its folder."""
        return self.file.replace("\\", "/").rpartition("/")[2]

    def problem(self, message: str) -> ProgramProblem:
        """Return a problem at this place."""
        return ProgramProblem(file=self.file, line=self.line, column=self.column, message=message)


NOWHERE = Place()


@dataclass(frozen=True)
class Achieve:
    """Subgoal `!g`, or with `new_focus` a separate goal `!!g`."""

    goal: Event
    new_focus: bool = False
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return f"{'!!' if self.new_focus else '!'}{self.goal}"


@dataclass(frozen=True)
class Test:
    """Query `?b`, which becomes a subgoal if it has no answer but a `+?b` plan."""

    formula: Term
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return f"?{text(self.formula)}"


@dataclass(frozen=True)
class Update:
    """Change of a belief, or of a rule in braces. `operator` is one of + +< +> ++ - -- -+."""

    operator: str
    belief: Event | Quoted
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return f"{self.operator}{self.belief}"


@dataclass(frozen=True)
class Act:
    """External or internal action, or a variable."""

    action: Event
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return str(self.action)


@dataclass(frozen=True)
class Constraint:
    """Expression in a body, such as `X = Y + 1`, which fails if it does not hold."""

    relation: Relation
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return str(self.relation)[1:-1]


@dataclass(frozen=True, kw_only=True)
class If:
    """`if (condition) { then } else { otherwise }`."""

    condition: Term
    then: Body
    otherwise: Body
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        tail = f" else {block_text(self.otherwise)}" if self.otherwise else ""
        return f"if ({text(self.condition)}) {block_text(self.then)}{tail}"


@dataclass(frozen=True)
class While:
    """`while (condition) { body }`."""

    condition: Term
    body: Body
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return f"while ({text(self.condition)}) {block_text(self.body)}"


@dataclass(frozen=True)
class For:
    """`for (generator) { body }`, which repeats the body for each solution."""

    generator: Term
    body: Body
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        return f"for ({text(self.generator)}) {block_text(self.body)}"


@dataclass(frozen=True)
class ForkJoin:
    """Concurrent branches, until all (`|&|`) or the first (`|||`) have ended."""

    all_of: bool
    branches: tuple[Body, ...]
    place: Place = field(default=NOWHERE, compare=False)

    def __str__(self) -> str:
        sign = " |&| " if self.all_of else " ||| "
        return sign.join(
            str(branch[0])
            if len(branch) == 1 and not isinstance(branch[0], ForkJoin | If | While | For)
            else f"({body_text(branch)})"
            for branch in self.branches
        )


BodyFormula: TypeAlias = Achieve | Test | Update | Act | Constraint | If | While | For | ForkJoin
Body: TypeAlias = tuple[BodyFormula, ...]


def steps_of(body: Body) -> Iterator[BodyFormula]:
    """Yield the steps of a body, each followed by its inner steps."""
    for step in body:
        yield step
        inner: tuple[Body, ...] = ()
        if isinstance(step, If):
            inner = (step.then, step.otherwise)
        elif isinstance(step, While | For):
            inner = (step.body,)
        elif isinstance(step, ForkJoin):
            inner = step.branches
        for part in inner:
            yield from steps_of(part)


def body_text(body: Body) -> str:
    """Return a body as AgentSpeak, with semicolons between the steps."""
    return "; ".join(map(str, body))


def block_text(body: Body) -> str:
    """Return a body as AgentSpeak, in braces."""
    return f"{{ {body_text(body)} }}" if body else "{ }"


_UPDATES = MappingProxyType(
    {
        "+": "addBel",
        "+<": "addBelBegin",
        "+>": "addBelEnd",
        "++": "addBelNewFocus",
        "-": "delBel",
        "--": "delBelNewFocus",
        "-+": "delAddBel",
    }
)


def _structure(step: BodyFormula) -> Literal | None:
    """Return a step as a structure named as in Jason, or None for a control structure."""
    if isinstance(step, Achieve):
        return Literal("achieveNF" if step.new_focus else "achieve", (step.goal,))
    if isinstance(step, Test):
        return Literal("test", (step.formula,))
    if isinstance(step, Update):
        return Literal(_UPDATES[step.operator], (step.belief,))
    if isinstance(step, Constraint):
        return Literal("constraint", (step.relation,))
    if isinstance(step, Act):
        is_internal = isinstance(step.action, Literal) and step.action.is_internal_action
        return Literal("internalAction" if is_internal else "action", (step.action,))
    return None


@dataclass(frozen=True)
class BodyTerm(Quoted):
    """Body as an argument, such as `{ !g; +b }`.

    `bare` is True for the body of a plan, which is printed without braces.
    """

    body: Body
    bare: bool = field(default=False, compare=False)

    @cached_property
    def ground(self) -> bool:
        """Whether it contains no variables."""
        return not has_variables(self.body)

    def changed(self, change: Callable[[Any], Any]) -> BodyTerm:
        """Return the term with all parts replaced for which `change` returns not None."""
        return BodyTerm(transformed(self.body, change), self.bare)

    @property
    def structure(self) -> Literal | None:
        """Body as a structure, such as `achieve(g)` or `achieve(g, { … })`, or None.

        Empty bodies and control structures have none.
        """
        first = _structure(self.body[0]) if self.body else None
        if first is None or len(self.body) == 1:
            return first
        return Literal(first.functor, (*first.args, BodyTerm(self.body[1:], self.bare)))

    @property
    def as_trigger(self) -> TriggerTerm | None:
        """Event of a body such as `{+b}`, or None."""
        if len(self.body) == 1 and isinstance(self.body[0], Update):
            update = self.body[0]
            belief = update.belief
            if update.operator in ("+", "-") and not isinstance(belief, Quoted):
                return TriggerTerm(update.operator, belief)
        return None

    def __str__(self) -> str:
        return body_text(self.body) if self.bare else block_text(self.body)
