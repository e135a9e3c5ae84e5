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
from navigation.kernels.edges import legs_of
from navigation.kernels.numbers import numbers
from navigation.kernels.retreats import Retreats, RetreatSearch

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


class Request(RetreatSearch):
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
        self._rank_counts = asker.time_blocked(now) <= PARAMETERS.rank_counts
        self._moving = RequestedMoves(commitments, now)
        """Drafts of the people who move for the request, the asker first."""
        super().__init__(
            self._moving, PARAMETERS.longest_chain, PARAMETERS.most_moved, PARAMETERS.tries
        )

    @property
    def drafts(self) -> dict[Traveller, Swath]:
        """Draft of each person who moves for the request."""
        return self._moving.drafts

    def succeeds(self, outlook: Outlook, passed: float) -> bool:
        """Return whether the asker gets past `passed` metres of the course if all move."""
        asker = self._commitments.indices[self._asker]
        for course, length in self._courses(outlook, passed):
            # People who cannot step aside during the longest wait never can.
            latest = outlook.draft(course, length, delay=PARAMETERS.waits[-1])
            if latest is None:
                continue
            if self.left <= 0:
                return False
            if self.clear(asker, latest, first(course, length)):
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
        self.refuse(manner.alone)
        if manner.alone:
            self.left = len(ESCAPES)
        for disc in discs:
            moving.move(indices[disc], disc.swath)
        walks = self._retreats(me, lead, manner)
        return self.step(walks, [*course], legs_of([]), 0)

    def make_way(self, course: Sequence[Point]) -> None:
        """Draft steps off the committed motion of the asker along `course`, as far as possible."""
        asker = self._asker
        self.clear(self._commitments.indices[asker], asker.swath, [*course])

    def ask(self, k: int) -> PersonRetreats | None:
        """See `RetreatSearch.ask`."""
        other, asker = self._commitments.people[k], self._asker
        if (
            other.recorded
            or other is asker
            or not other.manners.steps_aside
            or other.body.motion.end > self._now
            or (self._rank_counts and other.rank <= asker.rank and other not in self._behind)
        ):
            return None
        return self._retreats(other)

    def _retreats(
        self, who: Traveller, lead: Swath | None = None, manner: Retreating | None = None
    ) -> PersonRetreats:
        """Return the retreats of a person, from vehicles if there is a `manner`."""
        wide = self.left if manner else PARAMETERS.wide
        k = self._commitments.indices[who]
        return PersonRetreats(who, k, self._ground_of(who), self._moving, wide, lead, manner)


class PersonRetreats(Retreats):
    """Retreats of one person on the `ground`, from vehicles if there is a `manner`.

    Places around the person come first, then places ahead along the course.
    """

    def __init__(
        self,
        who: Traveller,
        index: int,
        ground: Ground,
        moving: RequestedMoves,
        wide: int,
        lead: Swath | None,
        manner: Retreating | None,
    ) -> None:
        self._who = who
        self._ground = ground
        self._moving = moving
        self._lead = lead
        self._struck = manner.struck if manner else None
        # This width assumes equal radii. The kernel checks each step exactly.
        self._width = 2 * who.radius + GAP
        margin = manner.margin if manner else 0.0
        self._own = who.radius + GAP + margin
        self._reach = PARAMETERS.escape if manner else PARAMETERS.rings[-1]
        start = who.swath.place if lead is None else lead.place
        super().__init__(
            moving,
            index,
            start,
            ESCAPES if manner else AROUND,
            self._width,
            ground.legs,
            who.top_speed,
            who.human.max_speed,
            who.human.max_acceleration,
            wide,
            lead,
            margin,
        )
        self._is_checked = self.is_checked([start, start])

    def is_checked(self, path: list[Point]) -> bool:
        """See `Retreats.is_checked`."""
        if len(path) == 1:
            return self._is_checked
        return bool(
            self._who.zones
            or self._struck
            or not self._ground.has_only_walls(path[-1], self._reach)
        )

    def fit(self, path: list[Point], walk: Swath) -> Swath | None:
        """See `Retreats.fit`."""
        if not self._ground.free_and_back(path[-2], path[-1]):
            return None
        slower = self._slower(path) if self._who.zones else walk
        return None if slower is None or (self._struck and self._struck(slower)) else slower

    def _slower(self, path: list[Point]) -> Swath | None:
        """Return the walk within the speed limits of zones, unless it meets a person who moves."""
        moving = self._moving
        walk = self._who.draft(path, moving.now, lead=self._lead)
        meets = walk and any(moving.meets(i, walk, self._own) for i in range(len(moving.indices)))
        return None if meets else walk

    def ahead(self, course: list[Point]) -> Iterator[tuple[list[Point], MutableSequence[float]]]:
        """See `Retreats.ahead`.

        If the course fills the aisle, the person walks ahead along it to the next wide place.
        """
        step = PARAMETERS.stride
        at = self.start
        beyond = rest(course, nearest_length(course, at) + step)
        lengths = (k * step for k in range(math.ceil(length_of(beyond) / step) + 1))
        for path in self._ground.paths_ahead(at, beyond, lengths):
            yield path, _beside(self._width)


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
