"""Requests to step aside: a blocked person asks the people in the way, who may ask others."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, MutableSequence, Sequence
from functools import lru_cache
from itertools import pairwise

from floorplan import Point
from floorplan.files.dataclass import dataclass
from navigation.kernels.committed import Movers
from navigation.kernels.discs import Swath
from navigation.kernels.numbers import numbers
from navigation.kernels.retreats import Retreats

from .commitments import GAP, Commitments
from .ground import Ground, first, length_of, nearest_length, rest
from .observe import Outlook
from .parameters import PARAMETERS
from .traveller import Traveller

AROUND = numbers(
    number
    for r in PARAMETERS.rings
    for k in range(PARAMETERS.angles)
    for angle in (2 * math.pi * k / PARAMETERS.angles,)
    for number in (r * math.cos(angle), r * math.sin(angle))
)
"""Positions around a person, the nearest first: x and y of each, m."""

_STEPS = range(
    -round(PARAMETERS.escape / PARAMETERS.raster), round(PARAMETERS.escape / PARAMETERS.raster) + 1
)
ESCAPES = numbers(
    PARAMETERS.raster * number
    for i, j in sorted(((i, j) for i in _STEPS for j in _STEPS), key=lambda at: math.hypot(*at))
    if 0 < math.hypot(i, j) <= _STEPS[-1]
    for number in (i, j)
)
"""Positions around a person who steps off the course of a vehicle, as `AROUND`."""


@dataclass(frozen=True, kw_only=True)
class Retreating:
    """Manner in which a person steps off the course of vehicles.

    Either `alone`, or asking the people in the way. `margin` is kept beyond the usual distance
    from the vehicles, m. `struck` rejects walks, if there is one.
    """

    alone: bool = False
    margin: float = 0.0
    struck: Callable[[Swath], bool] | None = None


class RequestedMoves(Movers):
    """Drafts of all people who move for one request, checked against each other and all others."""

    def __init__(self, commitments: Commitments, now: float) -> None:
        super().__init__(commitments, now)
        self._commitments = commitments

    @property
    def drafts(self) -> dict[Traveller, Swath]:
        """Draft of each person who moves."""
        people = self._commitments.people
        return {people[k]: self.swath_of(i) for i, k in enumerate(self.indices)}


class Request:
    """Request of a blocked `asker`, and the drafts of all people who move for it.

    Depth first: each asked person looks for the nearest position off the course of the asker, or
    for one ahead along it. Then the people in the way of this step are asked.

    Moving people refuse, because agreed passages stay valid. People of higher rank than the asker
    refuse too, unless they are `behind`: they wait for the asker, and profit from the move. After
    `PARAMETERS.rank_counts` the rank does not count, because people of high rank may have no way
    out. All drafts are checked against each other and against all committed motions.
    """

    def __init__(
        self,
        asker: Traveller,
        now: float,
        commitments: Commitments,
        ground_of: Callable[[Traveller], Ground],
        behind: Container[Traveller] = (),
    ) -> None:
        self._asker = asker
        self._now = now
        self._commitments = commitments
        self._ground_of = ground_of
        self._behind = behind
        self._left = PARAMETERS.tries
        self._refusing = bytearray()
        """For each person, whether they have refused, or found no place."""
        self._moving = RequestedMoves(commitments, now)
        """Drafts of the people who move for the request, the asker first."""

    @property
    def drafts(self) -> dict[Traveller, Swath]:
        """Draft of each person who moves for the request."""
        return self._moving.drafts

    def succeeds(self, outlook: Outlook, passed: float) -> bool:
        """Return whether the asker gets past `passed` metres of the course if all move."""
        for course, length in self._courses(outlook, passed):
            # People who cannot step aside during the longest wait never can.
            latest = outlook.draft(course, length, delay=PARAMETERS.waits[-1])
            if latest is None:
                continue
            if self._left <= 0:
                return False
            if self._clear_for_asker(latest, first(course, length)):
                self._set_out_sooner(outlook, course, length)
                return True
        return False

    def _courses(self, outlook: Outlook, passed: float) -> Iterator[tuple[Sequence[Point], float]]:
        """Yield courses of the asker past `passed` metres of its course, and their lengths (m).

        The course just past the blocking person is first. Courses beside it follow, and then the
        course up to the distance of foresight.
        """
        near = min(outlook.stop_beyond(passed + PARAMETERS.passed), outlook.whole)
        yield outlook.course, near
        for course in self._beside(outlook, near):
            yield course, near
        far = outlook.stop_beyond(outlook.reach)
        if far != near:
            yield outlook.course, far

    def _beside(self, outlook: Outlook, length: float) -> Iterator[Sequence[Point]]:
        """Yield courses beside the first `length` metres of the asker's course."""
        for side in PARAMETERS.shifts:
            steps = [
                min(k * PARAMETERS.lane, length)
                for k in range(1, math.ceil(length / PARAMETERS.lane) + 1)
            ]
            poses = [outlook.walks.course.after(along) for along in steps]
            course = [outlook.at, *((x - side * s, y + side * c) for x, y, c, s in poses)]
            if all(outlook.ground.free(a, b) for a, b in pairwise(course)):
                yield course

    def _set_out_sooner(self, outlook: Outlook, course: Sequence[Point], length: float) -> None:
        """Reduce the wait of the asker to the time in which all others have moved."""
        moving, asker = self._moving, self._commitments.indices[self._asker]
        for wait in PARAMETERS.waits[:-1]:
            draft = outlook.draft(course, length, delay=wait)
            if draft is None or moving.meet(asker, draft):
                continue
            if moving.first_other(asker, draft) < 0:
                moving.change(0, draft)
                return

    def step_aside(
        self,
        me: Traveller,
        lead: Swath | None,
        discs: Sequence[Traveller],
        course: Sequence[Point],
        manner: Retreating,
    ) -> bool:
        """Draft a step of `me` off the motions of vehicles. Return whether it exists.

        The step follows on `lead`, if there is one. If there is no place around, the person walks
        ahead of the vehicle along its `course`.
        """
        moving, indices = self._moving, self._commitments.indices
        self._refusing = bytearray(len(indices))
        if manner.alone:
            self._refusing = bytearray(b"\1" * len(indices))
            self._left = len(ESCAPES)
        for disc in discs:
            moving.move(indices[disc], disc.swath)
        return self._step(indices[me], course, 0, lead, manner)

    def make_way(self, course: Sequence[Point]) -> None:
        """Draft steps off the committed motion of the asker along `course`, as far as possible."""
        self._clear_for_asker(self._asker.swath, course)

    def _clear_for_asker(self, draft: Swath, course: Sequence[Point]) -> bool:
        """Draft steps of all people in the way of the asker. Return whether they exist."""
        moving = self._moving
        self._refusing = bytearray(len(self._commitments.people))
        moving.keep(0)
        moving.move(self._commitments.indices[self._asker], draft)
        return self._clear(0, course, 0, moving.first_hit(0))

    def _clear(self, mover: int, course: Sequence[Point], depth: int, hit: int) -> bool:
        """Draft steps of all people in the way of a mover. Return whether they exist.

        `hit` is the index of the first one, or -1.
        """
        # Check the drafts of a chain against each other and against the committed motions of all
        # others, because all people of the chain are committed together.
        moving = self._moving
        while hit >= 0:
            if self._is_enough(depth, len(moving.indices)) or self._refuses(hit):
                return False
            if not self._step(hit, course, depth):
                return False
            hit = moving.first_hit(mover)
        return True

    def _is_enough(self, depth: int, moving: int) -> bool:
        """Return whether a chain has its maximum length, or the request its maximum size."""
        return depth >= PARAMETERS.longest_chain or moving > PARAMETERS.most_moved

    def _refuses(self, k: int) -> bool:
        """Return whether a person refuses, and cache it."""
        if self._refusing[k]:
            return True
        other = self._commitments.people[k]
        refuses = not (
            other is not self._asker
            and other.manners.steps_aside
            and not other.recorded
            and other.body.motion.end <= self._now
            and (
                other.rank > self._asker.rank
                or other in self._behind
                or self._asker.time_blocked(self._now) > PARAMETERS.rank_counts
            )
        )
        self._refusing[k] = refuses
        return refuses

    def _step(
        self,
        k: int,
        course: Sequence[Point],
        depth: int,
        lead: Swath | None = None,
        manner: Retreating | None = None,
    ) -> bool:
        """Draft a step of person `k` off `course`. Return whether it exists."""
        # Depth first: a failed step removes all drafts made for it. A person without a place is not
        # asked again for this course, because the search would have the same result.
        moving = self._moving
        count = len(moving.indices)
        for retreat, walk, hit in self._retreats(k, course, depth, lead, manner):
            moving.move(k, walk)
            if self._clear(count, retreat, depth + 1, hit):
                return True
            moving.keep(count)
        self._refusing[k] = self._left > 0
        return False

    def _retreats(
        self,
        k: int,
        course: Sequence[Point],
        depth: int,
        lead: Swath | None,
        manner: Retreating | None,
    ) -> Iterator[tuple[list[Point], Swath, int]]:
        """Yield courses off `course` with their walks, and the index of the first person met or -1.

        Places around the person come first, then places ahead along `course`. No walk meets a
        person who moves, or first meets one who refuses. `manner` is that of a retreat from
        vehicles.
        """
        who = self._commitments.people[k]
        ground, moving, refusing = self._ground_of(who), self._moving, self._refusing
        if self._is_enough(depth + 1, len(moving.indices) + 1):
            refusing = bytearray(b"\1" * len(refusing))
        # This width assumes equal radii. The kernel checks each step exactly.
        width = 2 * who.radius + GAP
        margin = manner.margin if manner else 0.0
        own = who.radius + GAP + margin
        walks = Retreats(
            moving,
            k,
            [] if manner else [*course],
            width,
            ground.legs,
            who.top_speed,
            who.human.max_speed,
            who.human.max_acceleration,
            lead,
            margin,
        )
        path: list[Point] = []
        struck = manner and manner.struck

        def fitting(x: float, y: float, walk: Swath) -> Swath | None:
            if not ground.free_and_back(path[-1], (x, y)):
                return None
            if who.zones:
                slower = who.draft([*path, (x, y)], self._now, lead=lead)
                if slower is None or any(
                    moving.meets(i, slower, own) for i in range(len(moving.indices))
                ):
                    return None
                walk = slower
            return None if struck and struck(walk) else walk

        around, reach = (ESCAPES, PARAMETERS.escape) if manner else (AROUND, PARAMETERS.rings[-1])
        wide = self._left if manner else PARAMETERS.wide
        start = who.swath.place if lead is None else lead.place
        for path, places in _lookout(start, course, around, width, ground):
            walks.look(path, places)
            fit = (
                None
                if not who.zones and not struck and ground.has_only_walls(path[-1], reach)
                else fitting
            )
            while True:
                walk, place, hit, tried = walks.next(min(wide, self._left), fit, refusing)
                wide -= tried
                self._left -= tried
                if walk is None:
                    break
                x, y = path[-1]
                yield [*path, (x + places[2 * place], y + places[2 * place + 1])], walk, hit
            if wide <= 0 or self._left <= 0:
                return


def _lookout(
    at: Point,
    course: Sequence[Point],
    around: MutableSequence[float],
    width: float,
    ground: Ground,
) -> Iterator[tuple[list[Point], MutableSequence[float]]]:
    """Yield paths from `at`, and positions around their ends, relative to these (m).

    The positions `around` come first. If the course fills the aisle, the person walks ahead along
    it to the next wide place.
    """
    yield [at], around
    step = PARAMETERS.stride
    beyond = rest(course, nearest_length(course, at) + step)
    lengths = (k * step for k in range(math.ceil(length_of(beyond) / step) + 1))
    for path in ground.paths_ahead(at, beyond, lengths):
        yield path, _beside(width)


@lru_cache(maxsize=64)
def _beside(width: float) -> MutableSequence[float]:
    """Return positions beside the end of a path, x and y of each, `width` metres off and more."""
    return numbers(
        number
        for k in range(PARAMETERS.angles // 2)
        for angle in (4 * math.pi * k / PARAMETERS.angles,)
        for r in (width + 0.02, 1.3 * width)
        for number in (r * math.cos(angle), r * math.sin(angle))
    )
