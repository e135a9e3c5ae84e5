"""A person: a mind in a body on the floor.

This is where beliefs meet geometry: what happens around a person becomes percepts (`Senses`), and
the actions that their mind decides on (`Actions`) become errands and motions (`Errand`, `Walker`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import bdi
from floorplan import Human
from navigation import PathPlanner

from ..core.body import Body
from ..core.clock import Alarm, Turn
from ..core.events import HumanStarted, PersonalityChanged
from ..core.machine import Machine
from ..core.scenario import PersonEntry
from ..core.stage import Stage
from ..safety.referee import Referee
from ..safety.watches import Pair
from .actions import Actions, MindError
from .crossing import CrossingWatch
from .errand import Errand
from .minds import Mind
from .percepts import Senses
from .playback import Playback
from .programs import find_program
from .steering.crowd import Crowd
from .steering.manners import Manners
from .tracks.walks import RecordedWalk
from .walker import Place, Walker
from .work_board import WorkBoard
from .worker import Worker

MOST_AT_ONCE = 1000
"""Number of times a person may think or act at one instant; more count as an endless program."""


class Person:
    """One person of a stage, as `entry` has them.

    `make_mind` makes a mind of theirs that runs the program of an entry; `thought` is called when
    a mind of theirs has thought, so that others can hear the messages it sent. Tasks are on the
    `board`, if there are any. Somebody who was recorded walks their `walk`.
    """

    def __init__(
        self,
        stage: Stage,
        entry: PersonEntry,
        human: Human,
        planner: PathPlanner,
        *,
        at: Place,
        crowd: Crowd | None,
        index: int,
        manners: Manners,
        referee: Referee,
        make_mind: Callable[[Person, PersonEntry, Mind | None], Mind],
        thought: Callable[[Person], None],
        board: WorkBoard | None = None,
        walk: RecordedWalk | None = None,
    ) -> None:
        home = entry.home_on(stage.floorplan)
        assert home is not None  # else the trial is refused
        self.name = entry.name
        self.personality = entry.personality_name
        self.started_at: float | None = None
        self.walker = Walker(
            stage,
            entry.name,
            human,
            planner,
            at=at,
            heading=home.heading if entry.at is None else 0.0,
            arrived=lambda goal: self._errand.arrived(goal),
            crowd=crowd,
            index=index,
            manners=manners,
            recorded=walk is not None,
            blocked=lambda: self._senses.count("blocked"),
        )
        self._stage = stage
        self._clock = stage.clock
        self._entry = entry
        self._playback = (
            None if walk is None else Playback(stage, self.walker.traveller, walk, crowd)
        )
        self._referee = referee
        self._thought = thought
        self._senses = Senses(stage.clock, self._think)
        self._errand = Errand(stage, self.walker, self._senses)
        self.worker = (
            None
            if board is None
            else Worker(
                stage, entry, board, body=self.walker.body, human=human, senses=self._senses
            )
        )
        self._actions = Actions(stage, self.walker, self._errand, home, crowd, self.worker)
        self._enforcing = Alarm(stage.clock, self._enforce, Turn.INSISTENCE)
        self._reason = "gantry"
        self._instant = (stage.clock.now, 0)
        self._make_mind = partial(make_mind, self)
        self.mind = self._make_mind(entry, None)
        """The mind that decides for them."""
        self._senses.belong_to(self.mind)
        for machine in stage.machines.values():
            referee.watch(self, machine)
        for machine in stage.vehicles:
            machine.look_out_for(self.body, human.max_speed)
            CrossingWatch(Pair(stage, self, machine), human, self._errand.let_pass)

    def begin(self) -> None:
        """Wait for what lets them start, and for what changes their personality."""
        triggers, entry = self._stage.triggers, self._entry
        triggers.add(entry.start, self.start, who=self.name)
        for change in entry.changes:
            become = partial(self.change_personality, change.personality)
            triggers.add(change.when, become, who=self.name)

    @property
    def body(self) -> Body:
        """Their body."""
        return self.walker.body

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
            raise ValueError(f"{self.name} is told from outside what to do")
        if not isinstance(personality, bdi.Program):
            personality = bdi.load(find_program(str(personality), self._stage.folder))
        change = partial(self._become, personality)
        self._clock.call_at(self._clock.now, change, Turn.NOTICE)

    def _become(self, program: bdi.Program) -> None:
        name = Path(program.source).stem
        self._stage.record(PersonalityChanged(person=self.name, personality=name))
        self._errand.give_up()
        if self.worker is not None:
            self.worker.give_back()
        self.walker.stop()
        self.walker.speed_share = 1.0
        self.mind = self._make_mind(replace(self._entry, personality=program), self.mind)
        self._senses.belong_to(self.mind)

    @property
    def work_beliefs(self) -> bdi.LiveBeliefs:
        """What they always know about their work, if there is any."""
        return {} if self.worker is None else self.worker.beliefs()

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

    def warn(self, percept: str, machine: Machine) -> None:
        """Perceive `percept`, the referee's warning about `machine`.

        After a violation the person is put home even if the mind does not do so by itself: that
        is enforced once the mind has had its turn (`Turn.INSISTENCE`).
        """
        is_robot = machine.shape.category == "robot"
        if is_robot:
            self._senses.see("gantry_at", *machine.body.at)
        self._senses.count(percept)
        if percept != "gantry_detected" and not self.is_recorded:
            self._reason = "gantry" if is_robot else "agv"
            self._enforcing.set(self._clock.now)

    def floor_changed(self) -> None:
        """See whether the path is still free: a machine has come to rest on the floor."""
        self._errand.floor_changed()

    def act(self, action: bdi.Literal) -> bool:
        """Carry out an external action of the agent; return True if it could be."""
        self._count_at_once()
        return self._actions.perform(action)

    @property
    def put_home_at(self) -> float | None:
        """Instant at which they were last put home (seconds)."""
        return self._actions.put_home_at

    def wake(self) -> None:
        """Let the mind think earlier than expected, if a message gives it something to do."""
        if self.mind.next_wakeup is not None:
            self._senses.think_by(self.mind.next_wakeup)

    def _think(self) -> None:
        self._count_at_once()
        self.mind.advance(self._clock.now)
        self._senses.heard()
        self._thought(self)

    def _count_at_once(self) -> None:
        now = self._clock.now
        since, count = self._instant
        self._instant = (now, count + 1 if since == now else 1)
        if self._instant[1] > MOST_AT_ONCE:
            raise MindError(f"{self.name} acts for ever at t = {now:g} s without letting time pass")

    def _enforce(self) -> None:
        if self._actions.put_home_at != self._clock.now:
            self._actions.teleport(self._reason)
