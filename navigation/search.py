"""The search of a roadmap with the bends around the bodies that a path meets."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from floorplan import Point

from .bodies import Body
from .kernels.edges import Room
from .kernels.heap import Heap
from .kernels.search import Link, Search
from .roadmap import Roadmap

PATIENCE = 400
"""Number of links after which a search asks whether there is a path at all."""

_SOON = 32
"""Number of places at the top of the queue that the roadmap is to link at once."""


def shortest_path(
    roadmap: Roadmap,
    start: Point,
    goal: Point,
    straight: bool,
    bodies: Sequence[Body],
    room: Room,
    refused: Collection[tuple[Point, Point]],
    hopeless: Callable[[], bool],
) -> list[Point] | None:
    """Return the shortest path on `roadmap` round `bodies`, or None where there is none.

    `straight` is false where something fixed is in the way between start and goal, `room` what the
    floor and the bodies leave; `refused` links count for none. `hopeless()` is asked once if the
    search takes long, and ends it if it is true.
    """
    count = len(roadmap.bends)

    def links_of(bend: int, queue: Heap) -> list[Link]:
        # A heap has the bends that will be taken soon not far from its top.
        return roadmap.links_of(bend, (to for to in queue.first(_SOON) if to < count))

    around = [roadmap.around(body) for body in bodies]
    ends, not_to_take = [*start, *goal], set[tuple[int, int]]()
    try:
        queue = roadmap.queues.pop()
    except IndexError:
        queue = Heap()
    search = Search(
        roadmap.turns,
        roadmap.links,
        links_of,
        around,
        ends,
        straight,
        room,
        not_to_take,
        queue,
    )
    if refused:
        number = {search.place(k): k for k in range(search.goal + 1)}
        not_to_take |= {(number[a], number[b]) for a, b in refused if {a, b} <= number.keys()}
    chain = search.path(PATIENCE, hopeless)
    roadmap.queues.append(queue)
    return None if chain is None else [search.place(number) for number in chain]
