"""A person: a mind in a body on the floor, with drawn parameters and an entrance.

This is where beliefs meet geometry: what happens around a person becomes percepts (`Senses`), and
the actions that their mind decides on (`Actions`) become errands and motions (`Errand`, `Walker`).
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from random import Random
from typing import Any, TypeVar

import bdi
from bdi.reasoning.beliefs import LiveBeliefs
from floorplan import Human, Point, UserError
from navigation import PathPlanner, standing

from ..core.body import PERSON, Body, Machine, OnCommand, commands
from ..core.clock import Alarm, Clock, Turn
from ..core.entries import ALL_ROUND, drawn_figure, seed_of
from ..core.events import Awaited, Entered, HumanStarted, Left, PersonalityChanged
from ..core.scenario import PersonEntry, Scenario
from ..core.schedule import Duration
from ..core.stage import Stage
from ..safety.referee import Referee
from .actions import Actions, MindError
from .crowd.crowd import Crowd
from .crowd.parameters import drawn
from .crowd.places import wings
from .crowd.speed_zones import SpeedZones
from .crowd.traveller import AT_THE_DOOR, Traveller
from .errand import Errand
from .interaction import Interaction
from .minds import Mind, Outside, as_term
from .perception import Senses, SocialPerception, Vision
from .programs import find_program
from .tracks.playback import Playback
from .tracks.recorded_walks import RecordedWalk
from .walker import Walker
from .work import WorkBoard, Worker

_Made = TypeVar("_Made", bound=Scenario)


def with_figures(scenario: _Made) -> _Made:
    """Return the scenario in which every figure of its people is a number."""
    return scenario.with_people(lambda entry: _with_figures(entry, scenario.seed))


def _with_figures(entry: PersonEntry, seed: int) -> PersonEntry:
    if isinstance(entry.max_speed, tuple | Duration):
        speed = drawn_figure(entry.max_speed, seed, f"speed {entry.name}")
        entry = replace(entry, max_speed=speed)
    if entry.noticing == ALL_ROUND:
        return entry
    figures: dict[str, Any] = {
        name: drawn_figure(given, seed, f"{name} {entry.name}")
        for name in ("field_of_view", "reaction_time")
        for given in [getattr(entry.noticing, name)]
        if given is not None
    }
    return replace(entry, noticing=replace(entry.noticing, **figures))


def speed_of(entry: PersonEntry, usual: float) -> float:
    """Return the top speed (m/s) of somebody `with_figures`; `usual` is that of the floor."""
    speed = usual if entry.max_speed is None else entry.max_speed
    assert not isinstance(speed, tuple | Duration)
    return speed


def lag_of(entry: PersonEntry, seed: int) -> Callable[[], float] | None:
    """Return what gives the next lag (s) of somebody's agent; None if it has none.

    The lags are drawn from the trial's `seed` and the name alone.
    """
    lag = entry.agent_lag
    if lag is None:
        return None
    low, high = lag if isinstance(lag, tuple) else (lag, lag)
    return partial(Random(seed_of(seed, f"lag {entry.name}")).uniform, low, high)


LOOKS_AGAIN = 0.5
"""Seconds until somebody who finds no room to come in looks again."""


class Entrances:
    """People who want to come in: a queue for each place, first in, first out.

    Only the first of a queue looks for room, however many wait behind them.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._queues: dict[Point, deque[tuple[float, Callable[[], bool]]]] = {}

    def join(self, place: Point, come_in: Callable[[], bool]) -> None:
        """Queue at `place`; `come_in` is called when it is their turn, and returns whether it went.

        It is called at once, and every `LOOKS_AGAIN` seconds after that while they are the first.
        """
        queue = self._queues.setdefault(place, deque())
        queue.append((self._clock.now, come_in))
        if len(queue) == 1:
            self._look(place)

    def _look(self, place: Point) -> None:
        queue, now = self._queues[place], self._clock.now
        _, come_in = queue[0]
        if not come_in():
            queue[0] = (now + LOOKS_AGAIN, come_in)
        else:
            queue.popleft()
        if queue:
            self._clock.call_at(self._next(queue, now), lambda: self._look(place), Turn.NOTICE)

    def _next(self, queue: deque[tuple[float, Callable[[], bool]]], now: float) -> float:
        """Return when the first looks, who has looked in vain before at their own pace."""
        t, come_in = queue[0]
        while t < now:
            t += LOOKS_AGAIN
        queue[0] = (t, come_in)
        return t


MOST_AT_ONCE = 1000
"""Number of times a person may think or act at one instant; more count as an endless program."""


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """Parts of a trial that all people share.

    `make_mind` returns a mind of a person that runs the program of an entry, after the mind before
    it. `thought` is called after each thought, so that others hear the messages that it sent.
    """

    stage: Stage
    crowd: Crowd
    referee: Referee
    entrances: Entrances
    board: WorkBoard | None
    make_mind: Callable[[Person, PersonEntry, Mind | None], Mind]
    thought: Callable[[Person], None]
    seed: int


class Person:
    """One person of a stage, as `entry` has them. A recorded person walks their `walk`.

    `index` is their number among all people, and `slot` their place in a group that they follow.
    """

    on_command: OnCommand | None = None
    """Function that carries out and records commands from outside."""

    def __init__(
        self,
        surroundings: Surroundings,
        entry: PersonEntry,
        human: Human,
        planner: PathPlanner,
        *,
        at: Point,
        index: int,
        walk: RecordedWalk | None,
        slot: int | None,
    ) -> None:
        stage, crowd, seed = surroundings.stage, surroundings.crowd, surroundings.seed
        home = entry.home_on(stage.floorplan)
        assert home is not None  # else the trial is refused
        self.name = entry.name
        self.personality = entry.personality_name
        self.started_at: float | None = None
        enters_at = entry.entrance_on(stage.floorplan) if walk is None else walk.enters_at
        self._entrance = enters_at or at
        self.stays: list[tuple[float, float]] = [] if enters_at else [(0.0, math.inf)]
        """Intervals (s) on the floor. The last one is infinite until they leave."""
        self.is_awaited = enters_at is not None
        """Whether they are not on the floor at the start."""
        self._index = index
        self._seed = seed
        self._sink = entry.sink_on(stage.floorplan)
        heading = home.heading if entry.at is None else 0.0
        still = standing(at, heading=heading, start=stage.clock.now)
        traveller = Traveller(
            index,
            Body(stage.clock, entry.name, PERSON, still),
            human,
            drawn(entry.manners, seed, entry.name),
            planner.world,
            SpeedZones(stage.floorplan.zones, entry.name),
            recorded=walk is not None,
            leaves_at=self._sink,
        )
        self.walker = Walker(
            stage,
            traveller,
            planner,
            crowd,
            arrived=self._arrived,
            blocked=lambda: self._senses.count("blocked"),
            late=lambda goal: self._errand.resume(goal),
        )
        self._stage = stage
        self._clock = stage.clock
        self._entry = entry
        self._playback = (
            None if walk is None else Playback(stage, traveller, walk, crowd, self._come_or_go)
        )
        self._referee = surroundings.referee
        self._entrances = surroundings.entrances
        self._eyes = (
            None
            if entry.noticing == ALL_ROUND
            else Vision(stage, self.walker.body, human, entry.noticing)
        )
        self._thought = surroundings.thought
        self._senses = Senses(stage.clock, self._think, lag_of(entry, seed))
        self._errand = Errand(stage, self.walker, self._senses)
        self.worker = (
            None
            if surroundings.board is None
            else Worker(
                stage,
                entry,
                surroundings.board,
                body=self.walker.body,
                human=human,
                senses=self._senses,
            )
        )
        self._attention = Interaction(stage, self.walker, self._errand, crowd, slot)
        self._actions = Actions(
            stage, self.walker, self._errand, self._attention, home, crowd, self.worker
        )
        self._regard = SocialPerception(stage, self.walker.body, self._senses)
        self._crowd = crowd
        self._enforcing = Alarm(stage.clock, self._enforce, Turn.INSISTENCE)
        self._reason = "gantry"
        self._warned_at = stage.clock.now
        self._instant = (stage.clock.now, 0)
        self._make_mind = partial(surroundings.make_mind, self)
        self.mind = self._make_mind(entry, None)
        """The mind that decides for them."""
        self._senses.belong_to(self.mind)
        self._regard.belong_to(self.mind)
        for machine in stage.machines.values():
            self._referee.watch(self, machine)
        for machine in stage.vehicles:
            machine.look_out_for(self.body, human.max_speed)

    def begin(self) -> None:
        """Wait for what lets them start, and for what changes their personality."""
        triggers, entry = self._stage.triggers, self._entry
        if self.is_awaited:
            self._stage.record(Awaited(person=self.name, at=self._entrance))
        if entry.source is None:
            triggers.add(entry.start, self.start, who=self.name)
        else:
            join = partial(self._entrances.join, self._entrance, self._enter)
            self._clock.call_at(entry.source.time(self._seed), join, Turn.NOTICE)
        for change in entry.changes:
            become = partial(self.change_personality, change.personality)
            triggers.add(change.when, become, who=self.name)

    def _enter(self) -> bool:
        """Come in, if there is room at the entrance; return whether they did."""
        self._stage.place_machines()
        entrance, radius, source = self._entrance, self.walker.human.radius, self._entry.source
        at = self._crowd.room(entrance, radius, self.walker.traveller, within=AT_THE_DOOR)
        if source is not None and source.at in self._stage.active_closures:  # the door is closed
            at = None
        if at is None or math.dist(at, entrance) > AT_THE_DOOR:
            return False
        self._come_or_go(True, at)
        self.walker.put(at, 0.0)
        self.start()
        return True

    def _come_or_go(self, is_there: bool, at: Point | None = None) -> None:
        """Be on the floor from now on, or not any more."""
        now, kind = self._clock.now, Entered if is_there else Left
        if is_there:
            self.stays.append((now, math.inf))
        else:
            self.stays[-1] = (self.stays[-1][0], now)
        self._stage.record(kind(person=self.name, at=at or self.body.motion.state_before(now).at))

    @property
    def away(self) -> bool:
        """Whether they are not on the floor: not yet, or not any more."""
        return not self.stays or self.stays[-1][1] < math.inf

    @property
    def left_at(self) -> float | None:
        """When they left the floor (s), None if they have not, or have come again."""
        left = self.stays[-1][1] if self.stays else math.inf
        return None if left == math.inf else left

    def _arrived(self, goal: Point) -> None:
        """Take note that a goal is reached; at their sink people leave the floor."""
        self._errand.arrived(goal)
        if self._sink is not None and goal == self._sink:
            self._leave()

    def _leave(self) -> None:
        """Leave the floor, once the door is open, if they are at it."""
        at, sink = self.body.at, self._sink
        if sink is None or self.away or math.dist(at, sink) > AT_THE_DOOR:
            return
        if self._entry.sink in self._stage.active_closures:
            self._clock.call_at(self._clock.now + LOOKS_AGAIN, self._leave, Turn.NOTICE)
            return
        self.give_up()
        self._come_or_go(False, at)
        self.walker.put(wings(self._stage.floorplan, self._index), 0.0)

    @property
    def body(self) -> Body:
        """Their body."""
        return self.walker.body

    @property
    def reaction_time(self) -> float:
        """Seconds from when they see something until they perceive it."""
        return 0.0 if self._eyes is None else self._eyes.reaction_time

    def sees(self, machine: Machine) -> bool:
        """Return whether they can see `machine` now."""
        return self._eyes is None or self._eyes.see(machine)

    @property
    def radius(self) -> float:
        """Radius of their body in metres."""
        return self.walker.human.radius

    @property
    def is_recorded(self) -> bool:
        """True of somebody who walks as they were measured."""
        return self._playback is not None

    @property
    def visits(self) -> list[str]:
        """The stations where they arrived, in order."""
        return self._errand.visits

    def change_personality(self, personality: str | Path | bdi.Program) -> None:
        """From this instant on, let another program decide: a name, an .asl file, or a program.

        The errand under way is dropped: the person stands until the new mind acts. It
        believes what every mind does at the start, and where the person is going; percepts count
        on. `TrialError` or `bdi.ProgramError` if there is no such program, `ValueError` if
        the person has no mind of their own.
        """
        if not isinstance(self.mind, bdi.Agent):
            raise UserError(f"{self.name} is controlled from outside")
        if not isinstance(personality, bdi.Program):
            personality = bdi.load(find_program(str(personality), self._stage.code_folder.path))
        change = partial(self._become, personality)
        self._clock.call_at(self._clock.now, change, Turn.NOTICE)

    def _become(self, program: bdi.Program) -> None:
        name = Path(program.source).stem
        self._stage.record(PersonalityChanged(person=self.name, personality=name))
        self.give_up()
        self.walker.stop()
        self.walker.speed_share = 1.0
        self.mind = self._make_mind(replace(self._entry, personality=program), self.mind)
        self._senses.belong_to(self.mind)
        self._regard.belong_to(self.mind)

    def give_up(self) -> None:
        """Drop the errand under way, and the task."""
        self._errand.give_up()
        self._attention.give_up()
        if self.worker is not None:
            self.worker.give_back()

    @property
    def beliefs(self) -> LiveBeliefs:
        """What they always know about their work, if there is any, and about who is in the way.

        `waits_for(Who)`: who keeps them from going on now.
        """
        found = {} if self.worker is None else self.worker.beliefs()

        def waits_for() -> list[tuple[bdi.Term, ...]]:
            who = self._crowd.waits_for(self.walker.traveller)
            return [] if who is None else [(as_term(who),)]

        return {**found, ("waits_for", 1): waits_for}

    @commands
    def start(self) -> None:
        """Begin; a second time does nothing."""
        if self.started_at is None:
            self.started_at = self._clock.now
            self._stage.record(HumanStarted(person=self.name))
            self._referee.started(self)
            if self.worker is not None:
                self.worker.start()
            self._senses.see("human_start")
            if self._playback is not None:
                self._playback.begin()
            self._regard.start()

    def warn(self, percept: str, machine: Machine) -> None:
        """Perceive `percept`, the referee's warning about `machine`.

        After a violation the person is put home even if the mind does not do so by itself: that
        is enforced once the mind has thought about it (`Turn.INSISTENCE`).
        """
        is_robot = machine.shape.category == "robot"
        if is_robot:
            self._senses.see("gantry_at", *machine.body.at)
        self._senses.count(percept)
        if percept != "gantry_detected" and not self.is_recorded:
            self._reason = "gantry" if is_robot else "agv"
            self._warned_at = self._clock.now
            self._enforcing.set(self._senses.thinks_at)

    def heeds(self, percept: str) -> bool:
        """Return whether the mind heeds a percept about another person."""
        return self._regard.heeds(percept)

    def perceive(self, percept: str, who: str) -> None:
        """Perceive something about another person, if the mind heeds it."""
        self._regard.perceive(percept, who)

    def floor_changed(self, came: Collection[str]) -> None:
        """See whether the path is still free: a machine has come to rest on the floor."""
        self._errand.floor_changed(came)

    @commands
    def act(self, action: bdi.Literal) -> bool | bdi.Refused:
        """Carry out an external action of the agent; return True if it could be.

        Where it could not, the outcome has the reason, if there is one.

        `MindError`, with its place in the program, if it makes no sense.
        """
        try:
            self._count_at_once()
            self._errand.refusal = ""
            done = not self.away and self._actions.perform(action)
            refusal = self._errand.refusal
            return done if done or not refusal else bdi.Refused(refusal)
        except MindError as why:
            if isinstance(self.mind, bdi.Agent):
                raise MindError(self.mind.problem(str(why))) from None
            raise

    def send(self, to: Point) -> bool:
        """Walk to a place, or near it, as if they had decided to; return whether they set out.

        Who is not on the floor, has not begun or walks as they were measured doesn't.
        """
        here = self.started_at is not None and not (self.away or self.is_recorded)
        return here and self._actions.go_near(to)

    @property
    def put_home_at(self) -> float | None:
        """Instant at which they were last put home (seconds)."""
        return self._actions.put_home_at

    @commands
    def decide_by(self, t: float) -> None:
        """Call an external program for a decision at time `t` (s), unless it decides earlier."""
        if not isinstance(self.mind, Outside):
            raise UserError(f"{self.name} is not external")
        self.mind.wake_at = t
        self.wake()

    @commands
    def penalise(self) -> bool:
        """Count a penalty on request. See `Referee.penalise`."""
        return self._referee.penalise(self)

    def wake(self) -> None:
        """Let the mind think earlier than expected, if a message gives it something to do."""
        if self.mind.next_wakeup is not None:
            self._senses.think_by(self.mind.next_wakeup)

    def _think(self) -> None:
        if self.left_at is not None:
            return
        self._count_at_once()
        self.mind.advance(self._clock.now)
        self._senses.heard()
        self._thought(self)

    def _count_at_once(self) -> None:
        now = self._clock.now
        since, count = self._instant
        self._instant = (now, count + 1 if since == now else 1)
        if self._instant[1] > MOST_AT_ONCE:
            raise MindError(f"{self.name} repeats actions without end at t = {now:g} s")

    def _enforce(self) -> None:
        put_home_at = self._actions.put_home_at
        if put_home_at is None or put_home_at < self._warned_at:
            self._actions.teleport(self._reason)
