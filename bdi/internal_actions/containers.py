"""Maps, sets and queues as terms, and the internal actions on them."""

from __future__ import annotations

from bisect import insort
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TypeAlias, TypeVar

from ..language.operations import Quoted
from ..language.substitution import Unifier, standard_order
from ..language.terms import Cons, Literal, Nil, Term, Var, make_list, text
from ..reasoning.execution import Call
from .registry import STANDARD, wrong


class Container(Quoted):
    """Base of mutable terms that contain others and are equal only to themselves."""

    kind = ""

    def __len__(self) -> int:
        raise NotImplementedError

    def __iter__(self) -> Iterator[Term]:
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<{self}>"


class MapTerm(Container):
    """Values by keys, in the order of the keys."""

    kind = "map"

    def __init__(self, items: Iterable[tuple[Term, Term]] = ()) -> None:
        self.items = dict(items)

    def __len__(self) -> int:
        return len(self.items)

    def __iter__(self) -> Iterator[Term]:
        return iter(sorted(self.items, key=standard_order))

    def __str__(self) -> str:
        return f"{{{','.join(f'{text(key)}->{text(self.items[key])}' for key in self)}}}"


class SetTerm(Container):
    """Terms without duplicates, in order."""

    kind = "set"

    def __init__(self, items: Iterable[Term] = ()) -> None:
        self.items = set(items)

    def __len__(self) -> int:
        return len(self.items)

    def __iter__(self) -> Iterator[Term]:
        return iter(sorted(self.items, key=standard_order))

    def __str__(self) -> str:
        return f"{{{','.join(map(text, self))}}}"


class QueueTerm(Container):
    """Terms in order of arrival, or with `priority` in standard order."""

    kind = "queue"

    def __init__(self, items: Iterable[Term] = (), *, priority: bool = False) -> None:
        self.priority = priority
        self.items: list[Term] = []
        for item in items:
            self.add(item)

    def add(self, item: Term) -> None:
        """Insert a term."""
        if self.priority:
            insort(self.items, item, key=standard_order)
        else:
            self.items.append(item)

    def __len__(self) -> int:
        return len(self.items)

    def __iter__(self) -> Iterator[Term]:
        return iter(list(self.items))

    def __str__(self) -> str:
        return f"[{','.join(map(text, self))}]"


_C = TypeVar("_C", bound=Container)


def _given(kind: type[_C], name: str, term: Term) -> _C:
    if isinstance(term, kind):
        return term
    raise wrong(name, f"first argument must be a {kind.kind} and not '{text(term)}'.")


def _elements(name: str, term: Term) -> list[Term]:
    if isinstance(term, Nil | Cons | Container):
        return list(term)
    raise wrong(name, f"'{text(term)}' is neither a list nor a set nor a queue.")


def _on(kind: type[Container], name: str, change: Callable[..., object]) -> Callable[..., object]:
    """Return the action that changes a container, or a new one for an unbound variable."""

    def act(call: Call, target: Term, *others: Term) -> object:
        if not isinstance(target, Var):
            return change(call, _given(kind, name, target), *others)
        made = kind()
        bound = call.unify(target, made)
        if bound is None:
            return False
        outcome = change(Call(call.agent, bound, call.intention), made, *others)
        return bound if outcome is True else outcome

    return act


def _create(kind: type[Container]) -> Callable[..., object]:
    def create(call: Call, target: Term, *more: Term) -> object:
        made = kind()
        if isinstance(made, SetTerm) and more:
            made.items.update(_elements("set.create", more[0]))
        elif isinstance(made, QueueTerm) and more:
            made.priority = more[0] == Literal("priority")
        return call.unify(target, made)

    return create


def _clear(call: Call, container: MapTerm | SetTerm | QueueTerm) -> bool:
    container.items.clear()
    return True


def _copy(call: Call, container: Container, result: Term) -> object:
    made: Container
    if isinstance(container, MapTerm):
        made = MapTerm(container.items.items())
    elif isinstance(container, QueueTerm):
        made = QueueTerm(container, priority=container.priority)
    else:
        made = SetTerm(container)
    return call.unify(result, made)


def _to_list(call: Call, container: Container, result: Term) -> object:
    return call.unify(make_list(container), result)


# ---- maps


def put(call: Call, container: MapTerm, key: Term, value: Term) -> bool:
    """`.map.put(M, K, V)`: give a key a value."""
    container.items[key] = value
    return True


def get(call: Call, container: MapTerm, key: Term, value: Term, *default: Term) -> object:
    """`.map.get(M, K, V, Default?)`: the value of a key, or the default."""
    item = container.items.get(key, default[0] if default else None)
    return False if item is None else call.unify(value, item)


def remove_key(call: Call, container: MapTerm, key: Term, *value: Term) -> object:
    """`.map.remove(M, K, V?)`: remove an existing key with the value V."""
    item = container.items.pop(key, None)
    if item is None:
        return False
    return call.unify(value[0], item) if value else True


def keys(call: Call, container: MapTerm, key: Term) -> Iterator[Unifier]:
    """`.map.key(M, K)`: an answer for each key, in order."""
    return call.each(key, list(container))


def values(call: Call, container: MapTerm, value: Term) -> Iterator[Unifier]:
    """`.map.value(M, V)`: an answer for each value, in the order of the keys."""
    return call.each(value, [container.items[key] for key in container])


# ---- sets


def add(call: Call, container: SetTerm | QueueTerm, element: Term) -> bool:
    """`.set.add(S, E)`, `.queue.add(Q, E)`: add an element."""
    container.items.add(element) if isinstance(container, SetTerm) else container.add(element)
    return True


def add_all(call: Call, container: SetTerm | QueueTerm, elements: Term) -> bool:
    """`.set.add_all(S, Es)`, `.queue.add_all(Q, Es)`: add all elements of a list, set or queue."""
    for element in _elements("add_all", elements):
        add(call, container, element)
    return True


def remove(call: Call, container: SetTerm, element: Term) -> bool:
    """`.set.remove(S, E)`: remove an existing element."""
    if element not in container.items:
        return False
    container.items.remove(element)
    return True


def intersection(call: Call, container: SetTerm, others: Term) -> bool:
    """`.set.intersection(S, Es)`: remove all elements that are not among others."""
    container.items.intersection_update(_elements("set.intersection", others))
    return True


def difference(call: Call, container: SetTerm, others: Term) -> bool:
    """`.set.difference(S, Es)`: remove all elements that are among others."""
    container.items.difference_update(_elements("set.difference", others))
    return True


# ---- queues


def head(call: Call, container: QueueTerm, element: Term) -> object:
    """`.queue.head(Q, E)`: the first element."""
    return call.unify(element, container.items[0]) if container.items else False


def take(call: Call, container: QueueTerm, element: Term) -> object:
    """`.queue.remove(Q, E)`: remove the first element."""
    return call.unify(element, container.items.pop(0)) if container.items else False


_Actions: TypeAlias = Mapping[str, tuple[Callable[..., object], int, int]]
"""Functions, with the minimum and maximum number of arguments."""

_COMMON: _Actions = {"clear": (_clear, 1, 1), "copy": (_copy, 2, 2), "to_list": (_to_list, 2, 2)}
_OWN: Mapping[type[Container], _Actions] = {
    MapTerm: {
        "put": (put, 3, 3),
        "get": (get, 3, 4),
        "remove": (remove_key, 2, 3),
        "key": (keys, 2, 2),
        "value": (values, 2, 2),
    },
    SetTerm: {
        "add": (add, 2, 2),
        "add_all": (add_all, 2, 2),
        "remove": (remove, 2, 2),
        "union": (add_all, 2, 2),
        "intersection": (intersection, 2, 2),
        "difference": (difference, 2, 2),
    },
    QueueTerm: {
        "add": (add, 2, 2),
        "add_all": (add_all, 2, 2),
        "head": (head, 2, 2),
        "remove": (take, 2, 2),
    },
}

for _kind, _own in _OWN.items():
    STANDARD.add(f".{_kind.kind}.create", least=1, most=2)(_create(_kind))
    for _action, (_change, _least, _most) in {**_COMMON, **_own}.items():
        _name = f"{_kind.kind}.{_action}"
        STANDARD.add(f".{_name}", least=_least, most=_most)(_on(_kind, _name, _change))
