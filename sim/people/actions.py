"""Actions of people: names, arguments, and checks of programs."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from functools import cache

import bdi
from floorplan import Point, SafeZone, UserError

from ..core.body import Machine
from ..core.events import Teleport
from ..core.scenario import Scenario
from ..core.stage import Stage
from .crowd.crowd import Crowd
from .crowd.traveller import Traveller
from .errand import Errand
from .interaction import Interaction, NobodyError
from .perception import PERCEPTS
from .programs import load_program, modules_of
from .walker import Walker
from .work import Worker

GLANCE_AHEAD = 2.0
"""Seconds. `step_between` goes to the position of the gantry after this time."""

SMALLEST_STEP = 0.05
"""Metres. `move_away` fails if there is less room than this."""


OUT_OF_THE_WAY = 3.0
"""Metres. Default distance to which `avoid` goes."""

BESIDE_WORK = ("walk_speed", "begin_task", "take", "refuse", "work_pace", "let_pass")
"""Actions that do not interrupt the errand or the task of a person."""


class MindError(UserError):
    """Error of a program with an action that no person can carry out."""


class Actions:
    """Actions of one person, by their names in programs.

    The person is put at `home` after a violation. If there are several robots, "the gantry" is the
    nearest one.
    """

    def __init__(
        self,
        stage: Stage,
        walker: Walker,
        errand: Errand,
        attention: Interaction,
        home: SafeZone,
        crowd: Crowd,
        worker: Worker | None = None,
    ) -> None:
        self.put_home_at: float | None = None
        """Time of the last teleport home (s), or None."""
        self._stage = stage
        self._walker = walker
        self._errand = errand
        self._attention = attention
        self._home = home
        self._crowd = crowd
        self._worker = worker

    def perform(self, action: bdi.Literal) -> bool:
        """Carry out an external action. Return whether it succeeded.

        Raises `MindError` if there is no such action, or if its arguments are invalid.
        """
        if action.functor not in BESIDE_WORK:
            self._leave()
        works = self._worker is not None and action.functor in WORK
        perform = (WORK if works else ACTIONS).get(action.functor)
        name = self._walker.body.name
        if perform is None:
            known = ", ".join(ACTIONS if self._worker is None else ACTIONS | WORK)
            raise MindError(f"{name}: there is no action {action.functor!r} (there are: {known})")
        arguments = [*map(_value, action.args)]
        least, parameters = _takes(perform)
        kinds = [value.__class__.__name__ for value in arguments]
        if len(kinds) < least or kinds != [kind for _, kind in parameters[: len(kinds)]]:
            takes = ", ".join(parameter for parameter, _ in parameters)
            raise MindError(f"{name}: the action {action} should be {action.functor}({takes})")
        try:
            return perform(self._worker if works else self, *arguments)
        except NobodyError as why:
            raise MindError(f"{name}: the action {action}: {why}") from None

    def teleport(self, reason: str) -> bool:
        """Put the person home because of `reason`. Return whether there is room."""
        self.put_home_at = self._stage.clock.now
        self._leave()
        at = self._place_at_home()
        if at is None:
            return self._errand.fail(self._home.position, "there is no room at home")
        self._stage.record(Teleport(person=self._walker.body.name, reason=reason, to=at))
        self._walker.put(at, self._home.heading)
        return True

    def go_near(self, point: Point) -> bool:
        """Walk to the free place nearest to `point`. Return whether there is a path."""
        self._leave()
        return self._go_near(point)

    def _leave(self) -> None:
        """End the errand and the interaction, and pause the task."""
        self._errand.give_up()
        self._attention.give_up()
        if self._worker is not None:
            self._worker.pause()

    def _place_at_home(self) -> Point | None:
        """Return home, or the nearest free place beside a vehicle there, or None."""
        self._stage.place_machines()
        home, radius = self._home.position, self._walker.human.radius
        return self._crowd.room(home, radius, self._walker.traveller)

    def _move(self, x: float, y: float, z: float = 0.0) -> bool:
        return self._errand.go((x, y))

    def _stop_movement(self) -> bool:
        self._walker.stop()
        return True

    def _move_to_gantry(self) -> bool:
        robot = self._robot()
        return robot is not None and self._go_near(robot.body.at)

    def _step_between(self) -> bool:
        robot = self._robot()
        if robot is None:
            return False
        return self._go_near(robot.body.motion.state(self._stage.clock.now + GLANCE_AHEAD).at)

    def _move_away(self, metres: float) -> bool:
        robot = self._robot()
        return robot is not None and self._step_back(robot.body.at, metres)

    def _step_back(self, point: Point, metres: float) -> bool:
        """Walk straight away from `point` by `metres`, or by as much as is free."""
        self._stage.place_machines()
        (x, y), (gx, gy) = self._walker.body.at, point
        away = math.atan2(y - gy, x - gx)
        step, radius = metres, self._walker.human.radius
        while step >= SMALLEST_STEP:
            goal = (x + step * math.cos(away), y + step * math.sin(away))
            if self._walker.world.segment_free((x, y), goal, radius):
                return self._errand.go(goal)
            step /= 2
        return self._errand.fail((x, y), "there is no room to step back")

    def _teleport_safe(self) -> bool:
        return self.teleport("gantry")

    def _teleport_agv(self) -> bool:
        return self.teleport("agv")

    def _walk_speed(self, share: float) -> bool:
        if not 0 < share <= 1:
            return False
        self._walker.speed_share = share
        return True

    def _face_gantry(self) -> bool:
        robot = self._robot()
        if robot is None:
            return False
        self._walker.turn_to(robot.body.at)
        return True

    def _let_pass(self, who: str) -> bool:
        other = self._other(who)
        return other is not None and self._attention.let_pass(other)

    def _follow(self, who: str) -> bool:
        other = self._other(who)
        return other is not None and self._attention.follow(other)

    def _walk_with(self, who: str) -> bool:
        other = self._other(who)
        return other is not None and self._attention.walk_with(other)

    def _approach(self, who: str) -> bool:
        other = self._other(who)
        return other is not None and self._attention.approach(other)

    def _avoid(self, who: str, metres: float = OUT_OF_THE_WAY) -> bool:
        other = self._other(who)
        return other is not None and self._step_back(other.body.at, metres)

    def _other(self, who: str) -> Traveller | None:
        self._stage.place_machines()
        return self._attention.find(who)

    def _go_near(self, point: Point) -> bool:
        self._stage.place_machines()
        free = self._walker.world.nearest_free(point, self._walker.human.radius)
        if free is None:
            return self._errand.fail(point, "there is no room to stand anywhere")
        return self._errand.go(free)

    def _robot(self) -> Machine | None:
        here = self._walker.body.at
        return min(self._stage.robots, key=lambda r: math.dist(r.body.at, here), default=None)


ACTIONS: dict[str, Callable[..., bool]] = {
    "move": Actions._move,
    "stop_movement": Actions._stop_movement,
    "move_to_gantry": Actions._move_to_gantry,
    "teleport_safe": Actions._teleport_safe,
    "teleport_agv": Actions._teleport_agv,
    "walk_speed": Actions._walk_speed,
    "face_gantry": Actions._face_gantry,
    "move_away": Actions._move_away,
    "step_between": Actions._step_between,
    "let_pass": Actions._let_pass,
    "follow": Actions._follow,
    "walk_with": Actions._walk_with,
    "approach": Actions._approach,
    "avoid": Actions._avoid,
}
"""Actions of all people, by their names in programs."""

WORK: dict[str, Callable[..., bool]] = {
    "take": Worker.take,
    "begin_task": Worker.begin,
    "give_back": Worker.give_back,
    "refuse": Worker.refuse,
    "work_pace": Worker.work_pace,
}
"""Actions of people in a trial with work."""


def numbers_of_arguments() -> dict[str, tuple[int, int]]:
    """Return the minimum and maximum number of arguments of each action."""
    taken = {name: _takes(action) for name, action in (ACTIONS | WORK).items()}
    return {name: (least, len(parameters)) for name, (least, parameters) in taken.items()}


@cache
def _takes(action: Callable[..., bool]) -> tuple[int, list[tuple[str, str]]]:
    """Return the minimum number of arguments of an action, and the name and type of each."""
    _, *parameters = inspect.signature(action).parameters.values()
    least = sum(parameter.default is parameter.empty for parameter in parameters)
    return least, [(parameter.name, parameter.annotation) for parameter in parameters]


def _value(term: bdi.Term) -> float | str | None:
    """Return a term as a number or a name, or None."""
    if isinstance(term, float | str):
        return term
    if isinstance(term, bdi.Literal) and not term.args:
        return term.functor
    return None


def doubts_in(scenario: Scenario) -> tuple[bdi.ProgramProblem, ...]:
    """Return the warnings about the programs of all people of a trial."""
    used = {
        (personality, modules_of(person.actions, scenario.actions)): None
        for person in scenario.people
        for personality in (person.personality, *(one.personality for one in person.changes))
    }
    programs = [
        load_program(personality, scenario.code_folder, modules) for personality, modules in used
    ]
    doubts = (doubt for one in programs if one is not None for doubt in doubts_of(one))
    return tuple(dict.fromkeys(doubts))


def doubts_of(program: bdi.Program) -> tuple[bdi.ProgramProblem, ...]:
    """Return the warnings about the program of a person."""
    triggers = (plan.trigger for name in bdi.programs() for plan in bdi.load(name).plans)
    events = {one.literal.functor for one in triggers if not one.kind}  # type: ignore[union-attr]
    events |= {*PERCEPTS}
    return bdi.doubts(program, actions=numbers_of_arguments(), events=sorted(events))
