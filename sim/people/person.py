"""A person: a mind and a body on the floor, with drawn parameters and an entrance.

Events around a person become percepts (`Senses`). Actions of the mind (`Actions`) become errands
and motions (`Errand`, `Walker`).
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Collection
from dataclasses import replace
from functools import partial
from pathlib import Path
from random import Random
from typing import Any, TypeVar

import bdi
from bdi.reasoning.beliefs import LiveBeliefs
from floorplan import Human, Point, UserError
from floorplan.files.dataclass import dataclass
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
    """Return the scenario with numbers in place of the random parameters of people."""
    return scenario.with_people(lambda entry: _with_figures(entry, scenario.seed))


def _with_figures(entry: PersonEntry, seed: int) -> PersonEntry:
    if isinstance(entry.max_speed, tuple | Duration):
        speed = drawn_figure(entry.max_speed, seed, f"speed {entry.name}")
        entry = replace(entry, max_speed=speed)
    if entry.noticing == ALL_ROUND:
        return entry
    figures: dict[str, Any] = {
        name: drawn_figure(figure, seed, f"{name} {entry.name}")
        for name in ("field_of_view", "reaction_time")
        for figure in [getattr(entry.noticing, name)]
        if figure is not None
    }
    return replace(entry, noticing=replace(entry.noticing, **figures))


def speed_of(entry: PersonEntry, usual: float) -> float:
    """Return the top speed (m/s) of a person with drawn parameters, by default `usual`."""
    speed = usual if entry.max_speed is None else entry.max_speed
    assert not isinstance(speed, tuple | Duration)
    return speed


def lag_of(entry: PersonEntry, seed: int) -> Callable[[], float] | None:
    """Return a function that draws the next lag (s) of an agent, or None if there is none.

    The lags depend only on the seed of the trial and the name.
    """
    lag = entry.agent_lag
    if lag is None:
        return None
    low, high = lag if isinstance(lag, tuple) else (lag, lag)
    return partial(Random(seed_of(seed, f"lag {entry.name}")).uniform, low, high)


LOOKS_AGAIN = 0.5
"""Seconds between checks for room at an entrance."""


class Entrances:
    """Queues of people at entrances, first in, first out.

    Only the first person of a queue checks for room.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._queues: dict[Point, deque[tuple[float, Callable[[], bool]]]] = {}

    def join(self, place: Point, come_in: Callable[[], bool]) -> None:
        """Queue at `place`. `come_in` is called when it is their turn, and returns its success.

        It is called immediately, and every `LOOKS_AGAIN` seconds while they are the first.
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
        """Return the time (s) of the next check of the first person."""
        t, come_in = queue[0]
        while t < now:
            t += LOOKS_AGAIN
        queue[0] = (t, come_in)
        return t


MOST_AT_ONCE = 1000
"""Maximum number of thoughts and actions of a person at one time. More are an endless program."""


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """Parts of a trial that all people share.

    `make_mind` returns a mind for a person and an entry, the successor of another mind, if any.
    `thought` is called after each thought, to deliver the messages that it sent.
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
    """Person of a stage, as declared by `entry`. A recorded person follows `walk`.

    `index` is the number among all people, and `slot` the place in a group.
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
        assert home is not None  # trials without a home are rejected
        self.name = entry.name
        self.personality = entry.personality_name
        self.started_at: float | None = None
        enters_at = entry.entrance_on(stage.floorplan) if walk is None else walk.enters_at
        self._entrance = enters_at or at
        self.stays: list[tuple[float, float]] = [] if enters_at else [(0.0, math.inf)]
        """Intervals on the floor, s. The last one is infinite until the person leaves."""
        self.is_awaited = enters_at is not None
        """Whether they are absent at the start."""
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
        """Current mind."""
        self._senses.belong_to(self.mind)
        self._regard.belong_to(self.mind)
        for machine in stage.machines.values():
            self._referee.watch(self, machine)
        for machine in stage.vehicles:
            machine.look_out_for(self.body, human.max_speed)

    def begin(self) -> None:
        """Wait for the triggers of the start and of changes of personality."""
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
        """Come in if there is room at the entrance. Return whether they did."""
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
        """Enter or leave the floor."""
        now, kind = self._clock.now, Entered if is_there else Left
        if is_there:
            self.stays.append((now, math.inf))
        else:
            self.stays[-1] = (self.stays[-1][0], now)
        self._stage.record(kind(person=self.name, at=at or self.body.motion.state_before(now).at))

    @property
    def away(self) -> bool:
        """Whether they are absent: not yet on the floor, or no longer."""
        return not self.stays or self.stays[-1][1] < math.inf

    @property
    def left_at(self) -> float | None:
        """Time at which they left the floor (s). None if they have not, or have returned."""
        left = self.stays[-1][1] if self.stays else math.inf
        return None if left == math.inf else left

    def _arrived(self, goal: Point) -> None:
        """Handle the arrival at a goal. At the sink, leave the floor."""
        self._errand.arrived(goal)
        if self._sink is not None and goal == self._sink:
            self._leave()

    def _leave(self) -> None:
        """Leave the floor if they are at the sink and its door is open."""
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
        """Body of the person."""
        return self.walker.body

    @property
    def reaction_time(self) -> float:
        """Time between seeing and perceiving (s)."""
        return 0.0 if self._eyes is None else self._eyes.reaction_time

    def sees(self, machine: Machine) -> bool:
        """Return whether the person can see `machine` now."""
        return self._eyes is None or self._eyes.see(machine)

    @property
    def radius(self) -> float:
        """Radius of the body in metres."""
        return self.walker.human.radius

    @property
    def is_recorded(self) -> bool:
        """Whether they follow a recorded walk."""
        return self._playback is not None

    @property
    def visits(self) -> list[str]:
        """Stations reached, in order."""
        return self._errand.visits

    def change_personality(self, personality: str | Path | bdi.Program) -> None:
        """Run another program from now on, given by name, as an .asl file or as a program.

        The current errand ends, and the person stands until the new mind acts. The new mind has the
        initial beliefs, and those about the patrol. Percepts continue to be counted. Raises
        `TrialError` or `bdi.ProgramError` if there is no such program, and `ValueError` if the
        person has no agent.
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
        """End the errand and the interaction, and give the task back."""
        self._errand.give_up()
        self._attention.give_up()
        if self.worker is not None:
            self.worker.give_back()

    @property
    def beliefs(self) -> LiveBeliefs:
        """Live beliefs about work, and `waits_for(Who)` about the person who blocks the way."""
        about_work = {} if self.worker is None else self.worker.beliefs()

        def waits_for() -> list[tuple[bdi.Term, ...]]:
            who = self._crowd.waits_for(self.walker.traveller)
            return [] if who is None else [(as_term(who),)]

        return {**about_work, ("waits_for", 1): waits_for}

    @commands
    def start(self) -> None:
        """Start, unless they have started before."""
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
        """Perceive `percept`, the warning of the referee about `machine`.

        After a violation the person is put home (`Turn.INSISTENCE`), unless the mind has done so
        in its next thought.
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
        """Return whether the mind responds to a percept about another person."""
        return self._regard.heeds(percept)

    def perceive(self, percept: str, who: str) -> None:
        """Add a percept about another person if the mind responds to it."""
        self._regard.perceive(percept, who)

    def floor_changed(self, came: Collection[str]) -> None:
        """Check the path after a change of the floor. `came` are the names of new obstacles."""
        self._errand.floor_changed(came)

    @commands
    def act(self, action: bdi.Literal) -> bool | bdi.Refused:
        """Carry out an external action of the agent. Return True, or False or the reason.

        Raises `MindError`, with the location in the program, if the action is invalid.
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
        """Walk to a place or near it. Return whether they set out.

        Recorded people, and people who are absent or have not started, never do.
        """
        can_go = self.started_at is not None and not (self.away or self.is_recorded)
        return can_go and self._actions.go_near(to)

    @property
    def put_home_at(self) -> float | None:
        """Time of the last teleport home (s), or None."""
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
        """Schedule the next activity of the mind, for example after a message."""
        wakeup = self.mind.next_wakeup
        if wakeup is not None:
            self._senses.think_by(wakeup)

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
