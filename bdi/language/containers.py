"""Maps, sets and queues: terms that internal actions change."""

from __future__ import annotations

from bisect import insort
from collections.abc import Iterable, Iterator

from .order import standard_order
from .terms import Quoted, Term, text


class Container(Quoted):
    """Base of the terms that hold others and are equal only to themselves."""

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
    """Terms, each once, in order."""

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
    """Terms in the order in which they came, or, with `priority`, in standard order."""

    kind = "queue"

    def __init__(self, items: Iterable[Term] = (), *, priority: bool = False) -> None:
        self.priority = priority
        self.items: list[Term] = []
        for item in items:
            self.add(item)

    def add(self, item: Term) -> None:
        """Put a term in its place."""
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
