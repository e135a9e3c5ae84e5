"""A trial that is under way: everything that happens, from event to event."""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from itertools import takewhile
from pathlib import Path

import bdi
from floorplan import Gantry, require, suggestion
from navigation import CollisionWorld, PathPlanner

from .core import events
from .core.body import Body
from .core.clock import MOMENT, Clock
from .core.recorder import Event, Listener, Listeners, Thought, recording_to, rounded
from .core.scenario import PersonEntry
from .core.scene import Figure, Scene
from .core.start import Start
from .core.triggers import Triggers
from .machines.agv.agv import Agv
from .machines.agv.yielding import Foresight
from .machines.gantry.controllers import Controller, find_controller, parked, supervised
from .machines.gantry.robot import GantryRobot, Sighting, Surroundings
from .orders import Dispatcher
from .people.crossing import CrossingWatch
from .people.mind_inspector import MindInspector
from .people.minds import Mind, Outside, kept_beliefs, live_beliefs, make_agent
from .people.person import Person
from .people.programs import EXTERNAL, load_program
from .people.walker import Place, Walker
from .record.finished import Finished
from .record.summary import summarise
from .runs.run import Run
from .safety.own_law import own_laws
from .safety.proximity import ProximityWatch
from .safety.referee import Referee
from .safety.requirement_curve import requirement_curve
from .safety.watches import Pair
from .trials.checks import check
from .trials.names import fixed_places
from .trials.trial import Trial

MOST_AT_ONCE, MOST_AT_ONCE_EACH = 3000, 100
"""So many events may happen within a millisecond, and so many more for each body."""

MOST_NAMED = 5
"""So many kinds of events are named where simulated time stands still."""


class Simulation:
    """One trial, run step by step.

    `listeners` are told of events and motions as they happen. `advance` as far as you like,
    then `finish` for the `Run`. `TrialError` if there is something in the trial that can't be,
    `LawError` or `ControllerError` if a law or controller of the user's own can't be imported.
    """

    def __init__(self, trial: Trial, *listeners: Listener) -> None:
        self._cpu_begin = time.process_time()
        require(trial, Trial, "sim.Trial.load")
        check(trial)
        for law in own_laws(trial.rules):
            law.load()
        self._controller = _controller_of(trial)
        self.trial = trial
        self.clock = Clock(busy=self._busy)
        self.events: list[Event] = []
        self.thoughts: list[Thought] = []
        self._triggers = Triggers(self.clock)
        self._listener = Listeners(_Keeper(self.events), *listeners, _Reactor(self._triggers))
        self._record = recording_to(self._listener, lambda: self.clock.now)
        self._over = self.clock.end()
        self.world = CollisionWorld(trial.floorplan)
        self._planners: dict[float, PathPlanner] = {}
        self._places = fixed_places(trial.floorplan)
        self.people: list[Person] = []
        self._society = bdi.Society()
        self.agvs = [
            Agv(
                self.clock,
                lane,
                trial.agvs.get(lane.name, ()),
                record=self._record,
                stopped=self._agv_stopped,
                foresight=Foresight(lane, trial.rules) if lane.name in trial.yielding else None,
            )
            for lane in trial.floorplan.lanes
        ]
        self.gantry = self._make_gantry()
        self.referee = Referee(
            self.clock,
            trial.rules,
            trial.duration,
            record=self._record,
            warn=self._warn,
            disable_gantry=self.gantry.drive.disable if self.gantry else lambda _: None,
            hold=self._hold,
        )
        self.dispatcher = self._make_dispatcher()
        self._end_with_jobs()
        for entry in trial.people:
            self.people.append(self._make_person(entry))
        self.clock.most = MOST_AT_ONCE + MOST_AT_ONCE_EACH * len(self.bodies)
        self.scene = _scene_of(trial, self.bodies)
        self._listener.begin(self.scene)
        self._record(events.TrialStarted(trial=trial.name, floorplan=trial.floorplan.name))
        for notice in trial.notices:
            self._record(events.Notice(text=notice.message, field=notice.field, line=notice.line))
        for body in self.bodies:
            body.on_record = self._listener.motion
        if self.gantry is not None:
            self._start_controller(self.gantry)

    @property
    def bodies(self) -> list[Body]:
        """People, the gantry and the AGVs, in this order."""
        gantry = [self.gantry.body] if self.gantry else []
        return [*(p.walker.body for p in self.people), *gantry, *(agv.body for agv in self.agvs)]

    @property
    def over(self) -> bool:
        """Whether the trial has come to its end."""
        return self._over.triggered or self.clock.now >= self.trial.duration

    def person(self, name: str) -> Person:
        """The person of that name; `ValueError` that names those there are."""
        for person in self.people:
            if person.name == name:
                return person
        names = [person.name for person in self.people]
        raise ValueError(f"nobody is called {name!r}; {suggestion(name, names)}")

    def advance(self, until: float) -> None:
        """Let everything happen that happens before `until` (seconds), if that is still to come.

        `ValueError` if it is no time, `StandstillError` if simulated time does not go on.
        """
        if math.isnan(until):
            raise ValueError("a simulation can't be advanced to nan: give seconds")
        if until > self.clock.now and not self.over:
            self.clock.run(min(until, self.trial.duration))

    def finish(self) -> Run:
        """The run as far as it went."""
        interrupted = not self.over
        self.referee.close()
        if self.gantry is not None:
            self.gantry.drive.close()
        self._record(events.TrialEnded(interrupted=interrupted))
        motions = {body.name: body.track() for body in self.bodies}
        summary = summarise(
            Finished(
                trial=self.trial,
                duration=self.clock.now,
                interrupted=interrupted,
                people=self.people,
                gantry=self.gantry,
                referee=self.referee,
                motions=motions,
                work=self.dispatcher.figures if self.dispatcher else {},
            )
        )
        cpu = time.process_time() - self._cpu_begin
        summary["cpu_seconds"] = round(cpu, 6)
        summary["realtime_factor"] = round(self.clock.now / cpu, 1) if cpu > 0 else None
        return Run(
            trial=self.trial,
            scene=self.scene,
            duration=self.clock.now,
            summary=summary,
            events=tuple(self.events),
            motions=motions,
            violations={
                (watch.pair.person.name, watch.pair.machine.name): tuple(watch.intervals)
                for watch in self.referee.watches
            },
            thoughts=tuple(self.thoughts),
            requirements={
                (watch.pair.person.name, watch.pair.machine.name): requirement_curve(
                    watch.law, *watch.plans, self.clock.now
                )
                for watch in self.referee.watches
                if watch.plans is not None
            },
        )

    def _make_person(self, entry: PersonEntry) -> Person:
        plan = self.trial.floorplan
        home = entry.home_on(plan)
        assert home is not None  # else the trial is refused
        given = {
            name: getattr(entry, name)
            for name in ("radius", "max_speed", "max_acceleration")
            if getattr(entry, name) is not None
        }
        human = replace(plan.human, **given)
        walker = Walker(
            self.clock,
            entry.name,
            human,
            self._planner(human.radius),
            at=home.position if entry.at is None else entry.at,
            heading=home.heading if entry.at is None else 0.0,
            record=self._record,
            arrived=lambda goal: person.arrived(goal),
        )
        person = Person(
            self.clock,
            walker,
            plan,
            self.world,
            personality=entry.personality_name,
            gantry=self.gantry.body if self.gantry else None,
            record=self._record,
            synchronise=self._synchronise,
            started=lambda: self.referee.started(walker.body),
            thought=lambda: self._thought(person, inspector),
            make_mind=lambda program: make_mind(replace(entry, personality=program)),
            folder=self.trial.folder,
            home=home,
            zone=lambda name: self._agv(name).zone(self.trial.rules, human.max_speed),
        )
        inspector = self._inspector(entry.name)
        make_mind = partial(self._make_mind, person=person, inspector=inspector)
        person.think_with(make_mind(entry))
        self._triggers.add(entry.start, person.start, who=entry.name)
        for change in entry.changes:
            program = load_program(change.personality, self.trial.folder)
            assert program is not None  # nobody changes to somebody outside: it was checked
            other = partial(person.change_personality, program)
            self._triggers.add(change.when, other, who=entry.name)
        if self.gantry is not None:
            self.referee.watch_gantry(walker.body, self.gantry.body, self.gantry.drive.top_speed)
        for agv in self.agvs:
            self.referee.watch_agv(walker.body, agv.body, agv.lane)
            agv.look_out_for(walker.body, human.max_speed)
            pair = Pair(self.clock, walker.body, agv.body, self.trial.duration)
            CrossingWatch(pair, human, agv.lane, person.let_pass)
        return person

    def _make_mind(
        self, entry: PersonEntry, person: Person, inspector: MindInspector | None
    ) -> Mind:
        if entry.personality == EXTERNAL:
            return Outside()
        if person.mind is not None:
            self._society.leave(entry.name)
        return make_agent(
            entry,
            self.trial,
            act=person.act,
            print=lambda text: self._record(events.Said(person=entry.name, text=text)),
            on_event=lambda happening: self._heed(person, happening, inspector),
            society=self._society,
            start=self.clock.now,
            kept=kept_beliefs(person.mind),
            live=live_beliefs(
                person.walker.body,
                self.gantry.body if self.gantry else None,
                [agv.body for agv in self.agvs],
            ),
        )

    def _inspector(self, person: str) -> MindInspector | None:
        """Somebody who looks into a person's mind, if anybody wants to know."""
        if not self._listener.wants_thoughts:
            return None
        return MindInspector(person, self._keep_thought)

    def _keep_thought(self, thought: Thought) -> None:
        self.thoughts.append(thought)
        self._listener.thought(thought)

    def _thought(self, person: Person, inspector: MindInspector | None) -> None:
        """A person has thought: look what that has changed, and see who was spoken to."""
        if inspector is not None and isinstance(person.mind, bdi.Agent):
            inspector.look(rounded(self.clock.now), person.mind)
        self._wake()

    def _heed(self, person: Person, entry: bdi.Entry, inspector: MindInspector | None) -> None:
        """Write down what a program's author should know; the rest of a mind stays its own."""
        if inspector is not None:
            inspector.heed(entry)
        if entry.kind == "warning":
            file, line = (Path(entry.file).name, entry.line) if entry.file else (None, None)
            self._record(events.Warning(person=person.name, text=entry.text, file=file, line=line))

    def _busy(self) -> str:
        """What happens in this moment, by what was recorded of it, the most frequent first."""
        begin = rounded(self.clock.now - MOMENT)
        recent = takewhile(lambda event: event["t"] >= begin, reversed(self.events))
        kinds = Counter(_in_words(event) for event in recent)
        if max(kinds.values(), default=0) > 1:
            return ", ".join(words for words, n in kinds.most_common(MOST_NAMED) if n > 1)
        if self.gantry is None:
            return "nothing that is recorded"
        return (
            "nothing that is recorded, as where the gantry's controller"
            f" ({self.trial.gantry.controller_name}) waits for next to no time"
        )

    def _planner(self, radius: float) -> PathPlanner:
        """One planner for all people of a size: its network is worth sharing."""
        if radius not in self._planners:
            self._planners[radius] = PathPlanner(self.world, radius)
        return self._planners[radius]

    def _make_gantry(self) -> GantryRobot | None:
        gantry = self.trial.floorplan.gantry
        if gantry is None:
            return None
        entry = self.trial.gantry
        surroundings = Surroundings(
            floorplan=self.trial.floorplan,
            see=self._see,
            locate=partial(self._locate, gantry),
            rules=self.trial.rules,
            human_speed=max(
                (entry.max_speed or self.trial.floorplan.human.max_speed)
                for entry in (*self.trial.people, PersonEntry("anybody"))
            ),
        )
        return GantryRobot(self.clock, gantry, entry, surroundings, record=self._record)

    def _make_dispatcher(self) -> Dispatcher | None:
        trial = self.trial
        if trial.workload is None or self.gantry is None:
            return None
        return Dispatcher(
            self.clock,
            trial.workload,
            trial.floorplan,
            gantry=self.gantry,
            agvs=self.agvs,
            triggers=self._triggers,
            record=self._record,
            all_done=self._work_is_done,
        )

    def _end_with_jobs(self) -> None:
        """Let the run end when all orders are handed in, where the gantry's jobs hand them in."""
        orders = [job for job in self.trial.gantry.jobs if job.kind == "submit"]
        if orders and self.trial.workload is None:
            last = Start(event="order_submitted", count=len(orders))
            self._triggers.add(last, self._work_is_done)

    def _work_is_done(self) -> None:
        if self.trial.until_submitted and not self._over.triggered:
            self._over.succeed()

    def _start_controller(self, gantry: GantryRobot) -> None:
        people = [person.walker.body for person in self.people]
        gantry.on_interest = lambda: watch.near(gantry.close_distance)
        watch = ProximityWatch(
            self.clock,
            people,
            gantry.body,
            self.trial.duration,
            partial(gantry.interrupt, "person_close"),
        )
        name = self.trial.gantry.controller_name
        gantry.start(supervised(name, self._controller, gantry))

    def _see(self) -> tuple[Sighting, ...]:
        """The people as the gantry sees them now."""
        return tuple(
            Sighting(body.name, state.at, state.velocity[:2])
            for body in (person.walker.body for person in self.people)
            for state in [body.state]
        )

    def _warn(self, body: Body, percept: str, machine: Body) -> None:
        for person in self.people:
            if person.walker.body is body:
                person.warn(percept, machine)

    def _hold(self, machine: Body, stands: bool) -> None:
        if self.gantry is not None and machine is self.gantry.body:
            self.gantry.drive.hold(stands)
        else:
            self._agv(machine.name).hold(stands)

    def _agv_stopped(self, agv: Agv) -> None:
        self._synchronise()
        for person in self.people:
            person.check_way()
        if self.dispatcher is not None:
            self.dispatcher.agv_stopped(agv)
        if self.gantry is not None:
            self.gantry.floor_changed()

    def _agv(self, name: str) -> Agv:
        return next(agv for agv in self.agvs if agv.lane.name == name)

    def _synchronise(self) -> None:
        for agv in self.agvs:
            self.world.move_agv(agv.lane.name, agv.lane_position)

    def _wake(self) -> None:
        for person in self.people:
            person.wake()

    def _locate(self, gantry: Gantry, place: str) -> Place | None:
        """Where the gantry goes to for an obstacle, a station or an AGV of that name.

        None for an AGV that drives, or stands beyond the gantry's range.
        """
        for agv in self.agvs:
            if agv.lane.name == place:
                x, y = at = agv.body.at
                within = not gantry.faults((x, y, 0.0))
                return at if within and agv.body.motion.end <= self.clock.now else None
        if place not in self._places:
            raise ValueError(f"no obstacle, station or AGV is called {place!r}")
        return self._places[place]


def run(trial: Trial, *listeners: Listener) -> Run:
    """Run `trial` to its end; `listeners` are told of events and motions as they happen.

    Raises `TrialError` if there is something in the trial that can't be, `ControllerError`,
    `LawError` or `MindError` when the user's own programs go wrong, `StandstillError` when things
    happen again and again without letting time pass.
    """
    simulation = Simulation(trial, *listeners)
    simulation.advance(trial.duration)
    return simulation.finish()


def _controller_of(trial: Trial) -> Controller:
    """The controller of the trial's gantry; `parked` where the floor has none."""
    if trial.floorplan.gantry is None:
        return parked
    return find_controller(trial.gantry.controller, trial.folder, own_code=trial.own_code)


def _in_words(event: Event) -> str:
    """The kind of an event, and who took part."""
    who = [str(event[key]) for key in ("person", "with", "by", "agv", "job") if key in event]
    return f"{event['kind']} ({', '.join(who)})" if who else str(event["kind"])


def _scene_of(trial: Trial, bodies: Iterable[Body]) -> Scene:
    """The scene of a trial that is about to be run with these bodies."""
    human = trial.floorplan.human
    return Scene(
        trial=trial.name,
        seed=trial.seed,
        floorplan=trial.floorplan,
        rules=trial.rules,
        people=tuple(
            Figure(
                person.name, person.personality_name, person.radius or human.radius, human.height
            )
            for person in trial.people
        ),
        starts={body.name: body.state.position for body in bodies},
    )


class _Keeper(Listener):
    """Keeps the events of a run."""

    def __init__(self, events: list[Event]) -> None:
        self._events = events

    def event(self, event: Event) -> None:
        self._events.append(event)


class _Reactor(Listener):
    """Lets events have their consequences, after everybody else has been told of them."""

    def __init__(self, triggers: Triggers) -> None:
        self._triggers = triggers

    def event(self, event: Event) -> None:
        self._triggers.heed(event)
