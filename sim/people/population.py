"""All people of a trial, and what their agents share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import bdi
from floorplan import Human
from navigation import CollisionWorld, PathPlanner
from navigation.catalog import PlannerChoice

from ..core.events import Said, Warning
from ..core.recorder import Event, Listener, Thought, rounded
from ..core.scenario import PersonEntry, Scenario
from ..core.stage import Stage
from ..safety.proximity import Distancing
from ..safety.referee import Referee
from .crowd.custom_steering import make_crowd
from .crowd.places import starting_places, with_homes
from .minds import (
    STEPS,
    Mind,
    MindInspector,
    Mindless,
    Outside,
    kept_beliefs,
    live_beliefs,
    make_agent,
)
from .person import Entrances, Person, Surroundings
from .programs import EXTERNAL, Programs, find_planner, planner_of
from .tracks.recorded_walks import RecordedWalk, with_places
from .work import WorkBoard

MOST_PATHS = 256
"""Number of cached paths per planner. Patrols repeat the same queries."""

GROUP_PACE = 0.85
"""Speed of a group as a share of the lowest top speed, so that people who fall behind can catch
up."""

SEEDS = 2**32 - 1
"""Number of different seeds of OMPL."""


class _Society(bdi.Society):
    """Society of the minds, which records the receivers of messages during a thought."""

    def __init__(self) -> None:
        super().__init__()
        self.spoken_to: set[str] = set()

    def deliver(self, name: str, message: bdi.Message) -> None:
        """Deliver `message` to the mind called `name`. Raises `ActionError` if there is none."""
        super().deliver(name, message)
        self.spoken_to.add(name)


class Population:
    """People of a scenario on a stage, with the planners and the society that they share.

    Recorded people follow their `walks`, by name. Thoughts are collected in `thoughts` and passed
    to `listener` if it `wants_thoughts`.
    """

    def __init__(
        self,
        stage: Stage,
        scenario: Scenario,
        referee: Referee,
        listener: Listener,
        walks: Mapping[str, RecordedWalk],
    ) -> None:
        self.thoughts: list[Thought] = []
        self._stage = stage
        self._scenario = scenario
        self._listener = listener
        self._planners: dict[tuple[CollisionWorld, float, PlannerChoice], PathPlanner] = {}
        self._programs = Programs(scenario)
        self._society = _Society()
        self._inspectors: dict[str, MindInspector] = {}
        self._attentive: list[Person] | None = None
        """People whose minds respond to `has_left`. Computed when the first person leaves."""
        board = WorkBoard(scenario, stage.clock) if scenario.has_work else None
        self._board = board
        self.people: list[Person] = []
        self._crowd = crowd = make_crowd(stage, scenario.steering, scenario.seed)
        scenario = replace(scenario, people=with_places(scenario, walks))
        surroundings = Surroundings(
            stage=stage,
            crowd=crowd,
            referee=referee,
            entrances=Entrances(stage.clock),
            board=board,
            make_mind=self._make_mind,
            thought=self._thought,
            seed=scenario.seed,
        )
        starts = starting_places(scenario, stage.world, crowd)
        scenario = replace(scenario, people=with_homes(scenario, starts))
        for index, named in enumerate(scenario.people):
            entry = self._programs.with_changes(named)
            walk = walks.get(entry.name)
            human = _human(entry, stage.floorplan.human, walk)
            if led := scenario.led_by(entry):
                slowest = min(_human(one, stage.floorplan.human).max_speed for one in led)
                human = replace(human, max_speed=min(human.max_speed, GROUP_PACE * slowest))
            if listener.wants_thoughts:
                self._inspectors[entry.name] = MindInspector(entry.name, self._keep)
            person = Person(
                surroundings,
                entry,
                human,
                self._planner(entry.name, human.radius, planner_of(entry, scenario)),
                at=starts[index],
                index=index,
                walk=walk,
                slot=_slot(entry, scenario),
            )
            self.people.append(person)
        self._named = {person.name: person for person in self.people}
        self.distancing: Distancing | None = None
        """Monitor of the distances between people, if the rules require one."""

    def begin(self) -> None:
        """Schedule the starts of people and the appearance of work."""
        if self._crowd.is_shared:
            self._stage.triggers.each("met", self._perceive_meeting)
            self._stage.triggers.each("gave_way", self._perceive_request)
            self._stage.triggers.each("left", self._perceive_leaving)
        gap = self._stage.rules.between_people
        if gap is not None:
            radii = [person.walker.human.radius for person in self.people]
            self.distancing = Distancing(self._stage, self.people, radii, gap)
        if self._board is not None:
            self._board.begin()
        for person in self.people:
            person.begin()

    def _perceive_meeting(self, met: Event) -> None:
        self._named[met["person"]].perceive("in_the_way", met["other"])

    def _perceive_request(self, gave_way: Event) -> None:
        self._named[gave_way["to"]].perceive("gives_way", gave_way["person"])
        self._named[gave_way["person"]].perceive("wants_to_pass", gave_way["to"])

    def _perceive_leaving(self, left: Event) -> None:
        if self._attentive is None:
            self._attentive = [person for person in self.people if person.heeds("has_left")]
        for person in self._attentive:
            if person.name != left["person"]:
                person.perceive("has_left", left["person"])

    @property
    def deadlocks(self) -> int:
        """Number of times that no walking person could continue because of the others."""
        return self._crowd.deadlocks

    def _planner(self, person: str, radius: float, choice: PlannerChoice) -> PathPlanner:
        """Return the planner shared by people of the same radius, world and choice of planner."""
        world = self._stage.world_of(person)
        planner = self._planners.get((world, radius, choice))
        if planner is None:
            stage, seed = self._stage, self._scenario.seed % SEEDS
            loaded = find_planner(choice, stage.code_folder)
            planner = PathPlanner(world, radius, planner=loaded, seed=seed, keep=MOST_PATHS)
            self._planners[world, radius, choice] = planner
        return planner

    def _make_mind(self, person: Person, entry: PersonEntry, before: Mind | None) -> Mind:
        self._attentive = None
        if person.is_recorded:
            return Mindless()
        if entry.personality == EXTERNAL:
            return Outside()
        if before is not None:
            self._society.leave(entry.name)
        record = self._stage.record
        return make_agent(
            entry,
            self._scenario,
            self._programs,
            act=person.act,
            print=lambda text: record(Said(person=entry.name, text=text)),
            society=self._society,
            kept=kept_beliefs(before),
            settings=bdi.AgentSettings(
                start=self._stage.clock.now,
                live={**live_beliefs(person.body, self._stage), **person.beliefs},
                on_event=lambda entry: self._note(person.name, entry),
                kinds=STEPS if entry.name in self._inspectors else ("warning",),
            ),
        )

    def _keep(self, thought: Thought) -> None:
        self.thoughts.append(thought)
        self._listener.thought(thought)

    def _thought(self, person: Person) -> None:
        """Record the changes made by a thought, and wake the receivers of its messages."""
        inspector = self._inspectors.get(person.name)
        if inspector is not None and isinstance(person.mind, bdi.Agent):
            inspector.look(rounded(self._stage.clock.now), person.mind)
        spoken_to = self._society.spoken_to
        if not spoken_to:
            person.wake()
            return
        self._society.spoken_to = set()
        for listener in self.people:
            if listener is person or listener.name in spoken_to:
                listener.wake()

    def _note(self, person: str, entry: bdi.Entry) -> None:
        """Pass an entry to the inspector, and record warnings."""
        if person in self._inspectors:
            self._inspectors[person].note(entry)
        if entry.kind == "warning":
            file, line = (Path(entry.file).name, entry.line) if entry.file else (None, None)
            self._stage.record(Warning(person=person, text=entry.text, file=file, line=line))


def _slot(entry: PersonEntry, scenario: Scenario) -> int | None:
    """Return the place of a person in a group, or None."""
    leader = scenario.leader(entry)
    if leader is None:
        return None
    return [led.name for led in scenario.led_by(leader)].index(entry.name)


def _human(entry: PersonEntry, usual: Human, walk: RecordedWalk | None = None) -> Human:
    """Return the measures of a person, by default `usual`.

    The top speed is at least that of a recorded `walk`, because machines rely on it.
    """
    measures = {
        name: getattr(entry, name)
        for name in ("radius", "max_speed", "max_acceleration")
        if getattr(entry, name) is not None
    }
    human = replace(usual, **measures) if measures else usual
    if walk is None:
        return human
    return replace(human, max_speed=max(human.max_speed, walk.top_speed))
