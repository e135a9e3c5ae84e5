"""A person: a mind in a body on the floor.

This is where beliefs meet geometry. What happens around the person becomes percepts, and the
actions that the agent decides on become motions.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from functools import partial
from pathlib import Path

import bdi
from floorplan import Floorplan, SafeZone
from navigation import CollisionWorld, PlanningError

from ..core import events
from ..core.body import Body
from ..core.clock import Alarm, Clock, Turn
from ..core.recorder import Record
from .crossing import CrossingWatch
from .minds import Mind, Percepts
from .programs import find_program
from .waiting_place import WaitingPlaces
from .walker import Place, Walker

MOST_AT_ONCE = 1000
"""How often a person may think or act at one instant before the program counts as endless."""

GLANCE_AHEAD = 2.0
"""Seconds. `step_between` goes to where the gantry will be after this time."""

SMALLEST_STEP = 0.05
"""Metres. `move_away` fails where there is less room than this."""


class MindError(ValueError):
    """A personality's program asks for something that no person can do."""


class Person:
    """One person of a trial.

    `synchronise` puts the AGVs of the collision world where they are now; `started` is called
    when the person begins; `thought` is called
    when the mind has thought, so that others can hear what it said; `make_mind` makes another
    mind, whose program is looked up from `folder`. `zone(agv)` is how far (metres) from an
    AGV the person must stand for it to set out; `home` is where they are put after a violation.
    Plans are carried out by a `Walker`.
    """

    def __init__(
        self,
        clock: Clock,
        walker: Walker,
        plan: Floorplan,
        world: CollisionWorld,
        *,
        personality: str,
        gantry: Body | None,
        record: Record,
        synchronise: Callable[[], None],
        started: Callable[[], None],
        thought: Callable[[], None],
        make_mind: Callable[[bdi.Program], Mind],
        folder: Path,
        zone: Callable[[str], float],
        home: SafeZone,
    ) -> None:
        self.name = walker.body.name
        self.personality = personality
        self.walker = walker
        self.visits: list[str] = []
        self.started_at: float | None = None
        self._clock = clock
        self._plan = plan
        self._world = world
        self._gantry = gantry
        self._record = record
        self._synchronise = synchronise
        self._started = started
        self._thought = thought
        self._make_mind = make_mind
        self._folder = folder
        self._waiting_places = WaitingPlaces(world, walker.human.radius, zone)
        self._home = home
        self._put_home_at: float | None = None
        self._waits_for: Place | None = None
        self._lets_pass_on_way_to: Place | None = None
        self._thinking = Alarm(clock, self._think, Turn.THOUGHT)
        self._enforcing = Alarm(clock, self._enforce, Turn.INSISTENCE)
        self._reason = "gantry"
        self._instant = (clock.now, 0)
        self._actions: dict[str, Callable[..., bool]] = {
            "move": self._move,
            "stop_movement": self._stop_movement,
            "move_to_gantry": self._move_to_gantry,
            "teleport_safe": lambda: self._teleport("gantry"),
            "teleport_agv": lambda: self._teleport("agv"),
            "walk_speed": self._walk_speed,
            "face_gantry": self._face_gantry,
            "move_away": self._move_away,
            "step_between": self._step_between,
        }
        self._signatures = {name: inspect.signature(act) for name, act in self._actions.items()}
        self._mind: Mind | None = None
        self._percepts: Percepts | None = None

    def think_with(self, mind: Mind) -> None:
        """Let `mind` decide from now on; its actions are to be `self.act`."""
        self._mind = mind
        self._percepts = Percepts(mind)
        self._thinking.set(self._clock.now)

    @property
    def mind(self) -> Mind | None:
        """What decides for them."""
        return self._mind

    def change_personality(self, personality: str | Path | bdi.Program) -> None:
        """From this instant on, let another program decide: a name, an .asl file, or a program.

        What was under way is dropped: the person stands, until the new mind wants something. It
        believes what every mind does at the start, and where the person is going; percepts count
        on. `TrialError` or `bdi.ProgramError` if there is no such program, `ValueError` if
        the person has no mind of their own.
        """
        if not isinstance(self._mind, bdi.Agent):
            raise ValueError(f"{self.name} is told from outside what to do")
        if not isinstance(personality, bdi.Program):
            personality = bdi.load(find_program(str(personality), self._folder))
        change = partial(self._become, personality)
        self._clock.call_at(self._clock.now, change, Turn.NOTICE)

    def _become(self, program: bdi.Program) -> None:
        assert self._percepts is not None
        name = Path(program.source).stem
        self._record(events.PersonalityChanged(person=self.name, personality=name))
        self._forget_waits()
        self.walker.stop()
        self.walker.speed_share = 1.0
        mind = self._make_mind(program)
        self._mind, self._percepts = mind, self._percepts.pass_on(mind)
        self._thinking.set(self._clock.now)

    def start(self) -> None:
        """The person begins; a second time does nothing."""
        if self.started_at is None:
            self.started_at = self._clock.now
            self._record(events.HumanStarted(person=self.name))
            self._started()
            self._perceive("human_start")

    def warn(self, percept: str, machine: Body) -> None:
        """The referee's word: `percept` is about `machine`. The safe zone is not optional."""
        if machine.kind == "gantry":
            x, y = machine.at
            self._perceive("gantry_at", x, y)
        self._count(percept)
        if percept != "gantry_detected":
            self._reason = machine.kind
            self._enforcing.set(self._clock.now)

    def check_way(self) -> None:
        """Something has come to rest on the floor: see whether the way is still free."""
        if self._waits_for is not None:
            self._check_wait(self._waits_for)
            return
        if self._lets_pass_on_way_to is not None:
            onwards, self._lets_pass_on_way_to = self._lets_pass_on_way_to, None
            if self._set_out(onwards):
                self.walker.replans += 1
                self._record(events.Replanned(person=self.name, goal=onwards))
            return
        goal = self.walker.goal
        trouble = self.walker.check_way()
        if trouble is None or goal is None:
            return
        at_the_goal = trouble.reason == "goal_blocked"
        if not (at_the_goal and self._wait_beside(goal)):
            self._count("goal_blocked" if at_the_goal else "path_blocked")

    def let_pass(self, crossing: CrossingWatch) -> None:
        """Stop for an AGV that drives into the way, and go on when it has come to rest.

        Where stopping would not help, walk on.
        """
        goal = self.walker.goal
        if goal is None or self._waits_for is not None:
            return
        if crossing.touches(self.walker.braking()) is None:
            self._record(
                events.PathBlocked(person=self.name, goal=goal, by=crossing.pair.machine.name)
            )
            self.walker.stop()
            self._lets_pass_on_way_to = goal

    def _check_wait(self, goal: Place) -> None:
        """Go on to `goal` if it is free now; else go on waiting."""
        if self._waiting_places.occupant(goal) is None:
            self._waits_for = None
            self._record(events.GoalFree(person=self.name, goal=goal))
            self._set_out(goal)
        elif self.walker.check_way() is not None and not self._wait_beside(goal):
            self._no_way(goal, "there is no way to a place to wait", at_the_goal=True)

    def arrived(self, goal: Place) -> None:
        """The walker has reached `goal`, or the place to wait for it."""
        if self._waits_for is not None:
            self._count("goal_occupied")
            return
        station = self._station_at(goal)
        self._record(events.Arrived(person=self.name, station=station, at=goal))
        if station is not None:
            self.visits.append(station)
        x, y = self.walker.body.at
        self._perceive("at", x, y)
        self._count("work_completed")

    def act(self, action: bdi.Literal) -> bool:
        """Carry out an external action of the agent; whether it could be."""
        self._count_at_once()
        if action.functor != "walk_speed":
            self._forget_waits()
        perform = self._actions.get(action.functor)
        if perform is None:
            known = ", ".join(self._actions)
            raise MindError(
                f"{self.name}: there is no action {action.functor!r} (there are: {known})"
            )
        try:
            arguments = [_number(argument) for argument in action.args]
            self._signatures[action.functor].bind(*arguments)
        except (TypeError, ValueError):
            takes = ", ".join(self._signatures[action.functor].parameters)
            raise MindError(
                f"{self.name}: the action {action} should be {action.functor}({takes})"
            ) from None
        return perform(*arguments)

    # What the agent can do.

    def _move(self, x: float, y: float, z: float = 0.0) -> bool:
        return self._go((x, y))

    def _stop_movement(self) -> bool:
        self.walker.stop()
        return True

    def _move_to_gantry(self) -> bool:
        return self._gantry is not None and self._go_near(self._gantry.at)

    def _step_between(self) -> bool:
        if self._gantry is None:
            return False
        return self._go_near(self._gantry.motion.state(self._clock.now + GLANCE_AHEAD).at)

    def _move_away(self, metres: float) -> bool:
        if self._gantry is None:
            return False
        self._synchronise()
        (x, y), (gx, gy) = self.walker.body.at, self._gantry.at
        away = math.atan2(y - gy, x - gx)
        step, radius = metres, self.walker.human.radius
        while step >= SMALLEST_STEP:
            goal = (x + step * math.cos(away), y + step * math.sin(away))
            if self._world.segment_free((x, y), goal, radius):
                return self._go(goal)
            step /= 2
        return self._no_way((x, y), "there is no room to step back")

    def _teleport(self, reason: str) -> bool:
        self._put_home_at = self._clock.now
        self._forget_waits()
        at = self._place_at_home()
        if at is None:
            return self._no_way(self._home.position, "there is no room at home")
        self._record(events.Teleport(person=self.name, reason=reason, to=at))
        self.walker.put(at, self._home.heading)
        return True

    def _place_at_home(self) -> Place | None:
        """Home, or the nearest place beside the AGV that stands there."""
        self._synchronise()
        home, radius = self._home.position, self.walker.human.radius
        if not self._world.hits(home, home, radius):
            return home
        return next(iter(self._world.exits(home, radius)), None)

    def _walk_speed(self, share: float) -> bool:
        if not 0 < share <= 1:
            return False
        self.walker.speed_share = share
        return True

    def _face_gantry(self) -> bool:
        if self._gantry is None:
            return False
        self.walker.turn_to(self._gantry.at)
        return True

    def _go_near(self, point: Place) -> bool:
        self._synchronise()
        free = self._world.nearest_free(point, self.walker.human.radius)
        if free is None:
            return self._no_way(point, "there is no room to stand anywhere")
        return self._go(free)

    def _go(self, goal: Place) -> bool:
        self._synchronise()
        self._record(events.Goal(person=self.name, station=self._station_at(goal), at=goal))
        return self._set_out(goal)

    def _set_out(self, goal: Place) -> bool:
        try:
            self.walker.go(goal)
        except PlanningError as why:
            at_the_goal = why.reason == "goal_blocked"
            if at_the_goal and self._wait_beside(goal):
                return True
            return self._no_way(goal, str(why), at_the_goal)
        return True

    def _wait_beside(self, goal: Place) -> bool:
        """Wait near a goal that an AGV stands on, and go on when it has left; whether one does."""
        self._waits_for = None
        agv = self._waiting_places.occupant(goal)
        place = None if agv is None else self._waiting_places.beside(goal, agv)
        if place is None:
            return False
        try:
            self.walker.go(place)
        except PlanningError:
            return False
        self._waits_for = goal
        self._record(events.GoalOccupied(person=self.name, goal=goal, by=agv))
        return True

    # What the agent is told.

    def _no_way(self, goal: Place, message: str, at_the_goal: bool = False) -> bool:
        """Tell that there is no way to `goal`; False, as the outcome of the action."""
        self._record(events.PathBlocked(person=self.name, goal=goal, message=message))
        self._count("goal_blocked" if at_the_goal else "path_blocked")
        return False

    def _count(self, percept: str) -> None:
        if self._percepts is not None:
            self._percepts.count(percept)
            self._thinking.set(self._clock.now)

    def _perceive(self, functor: str, *arguments: float) -> None:
        if self._percepts is not None:
            self._percepts.see(functor, *arguments)
            self._thinking.set(self._clock.now)

    def _think(self) -> None:
        assert self._mind is not None
        now = self._clock.now
        self._count_at_once()
        self._mind.advance(now)
        if self._percepts is not None:
            self._percepts.heard()
        self._thought()

    def wake(self) -> None:
        """See whether there is something to think about earlier than expected: a message."""
        if self._mind is None or self._mind.next_wakeup is None:
            return
        wakeup = max(self._mind.next_wakeup, self._clock.now)
        if self._thinking.time is None or wakeup < self._thinking.time:
            self._thinking.set(wakeup)

    def _count_at_once(self) -> None:
        now = self._clock.now
        since, count = self._instant
        self._instant = (now, count + 1 if since == now else 1)
        if self._instant[1] > MOST_AT_ONCE:
            raise MindError(f"{self.name} acts for ever at t = {now:g} s without letting time pass")

    def _enforce(self) -> None:
        if self._put_home_at != self._clock.now:
            self._teleport(self._reason)

    def _forget_waits(self) -> None:
        self._waits_for = self._lets_pass_on_way_to = None

    def _station_at(self, point: Place) -> str | None:
        tolerance = self.walker.human.goal_tolerance
        near = [
            (distance, station.name)
            for station in self._plan.stations
            for distance in [math.dist(station.position, point)]
            if distance <= tolerance
        ]
        return min(near)[1] if near else None


def _number(term: bdi.Term) -> float:
    if isinstance(term, float):
        return term
    raise ValueError(f"{term} is not a number")
