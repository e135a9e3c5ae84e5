"""What an internal action is, and what it gets to work with."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from ..failure import ActionError
from ..terms import Cons, Literal, Nil, Term, Var, make_term, text
from ..unify import Unifier, unified

if TYPE_CHECKING:
    from ..agent import Agent
    from ..intentions import Intention

#: Takes a Call and the arguments; answers whether it holds, or with unifiers.
Function: TypeAlias = "Callable[..., Any]"


class Call:
    """One use of an internal action.

    `unifier` is what the variables stand for, and stays as it is: an action
    answers with new unifiers. `intention` is None in a context.
    """

    __slots__ = ("agent", "intention", "unifier")

    def __init__(self, agent: Agent, unifier: Unifier, intention: Intention | None) -> None:
        self.agent = agent
        self.unifier = unifier
        self.intention = intention

    def unify(self, one: object, other: object) -> Unifier | None:
        """A unifier with which the two are equal, or None: what an action returns.

        Python numbers, strs and lists are made terms.
        """
        return unified(make_term(one), make_term(other), self.unifier)

    def each(self, variable: Term, values: Iterable[object]) -> Iterator[Unifier]:
        """A unifier for each of the values that `variable` can be."""
        for value in values:
            solution = self.unify(variable, value)
            if solution is not None:
                yield solution


@dataclass(frozen=True)
class InternalAction:
    """A function with the numbers of arguments it takes (`most` None: as many as you like)."""

    function: Function
    least: int = 0
    most: int | None = None
    in_context: bool = True

    def check(self, name: str, count: int) -> None:
        """Raises ActionError when `name` is called with a `count` of arguments it does not take."""
        if count < self.least or (self.most is not None and count > self.most):
            if self.least == self.most:
                wanted = (
                    " One argument is expected."
                    if self.least == 1
                    else f" {self.least} arguments are expected."
                )
            else:
                most = 2**31 - 1 if self.most is None else self.most
                wanted = f" From {self.least} to {most} arguments are expected."
            raise ActionError(
                f"The internal action '{name.lstrip('.')}' has not received the required number"
                f" of argument(s).{wanted}",
                "wrong_arguments",
            )


class InternalActions(Mapping[str, InternalAction]):
    """Internal actions of your own, to be given to agents as `actions=`.

    ```python
    actions = bdi.InternalActions()

    @actions.add("floor.distance")
    def distance(call, x, y, result):
        return call.unify(result, math.hypot(x, y))
    ```
    """

    def __init__(self) -> None:
        self._actions: dict[str, InternalAction] = {}

    def add(
        self, name: str, *, least: int = 0, most: int | None = None, in_context: bool = True
    ) -> Callable[[Function], Function]:
        """Registers a function under a name with a dot in it, as `floor.distance`.

        Args:
            name: what programs call it.
            least: how many arguments it takes at least.
            most: how many at most.
            in_context: whether contexts and queries may use it.

        Raises:
            ValueError: the name has no dot or is taken.
        """
        if "." not in name:
            raise ValueError(f"the name of an internal action has a dot in it, and '{name}' none")
        if name in self._actions:
            raise ValueError(f"there is an internal action '{name}' already")

        def register(function: Function) -> Function:
            self._actions[name] = InternalAction(function, least, most, in_context)
            return function

        return register

    def __getitem__(self, name: str) -> InternalAction:
        return self._actions[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._actions)

    def __len__(self) -> int:
        return len(self._actions)


# ---- arguments of the right kind


def wrong(name: str, reason: str) -> ActionError:
    return ActionError(f"Wrong argument for internal action '{name}': {reason}", "wrong_arguments")


def a_list(name: str, term: Term, which: str) -> Nil | Cons:
    if isinstance(term, Nil | Cons):
        return term
    raise wrong(name, f"{which} argument must be a list and not '{text(term)}'.")


def a_number(name: str, term: Term, which: str) -> float:
    if isinstance(term, float):
        return term
    raise wrong(name, f"{which} parameter ('{text(term)}') must be a number!")


def a_literal(name: str, term: Term, which: str = "first") -> Literal:
    if isinstance(term, Literal):
        return term
    raise wrong(name, f"{which} argument must be a literal")


def a_goal(name: str, term: Term) -> Literal | Var:
    if isinstance(term, Literal | Var):
        return term
    raise wrong(name, f"first argument '{text(term)}' must be a literal or variable")


def plain(term: Term) -> str:
    """A string as it is; any other term as it prints."""
    return term if isinstance(term, str) else text(term)
