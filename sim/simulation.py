"""Simulation of a trial: assemble it, process its events, carry out commands."""

from __future__ import annotations

import math
import time
from bisect import insort
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial, wraps
from itertools import takewhile
from numbers import Real
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, TypeVar

from floorplan import InputError, UserError
from floorplan.files.collector import frozen_collector
from floorplan.files.problems import refuse, suggestion
from floorplan.files.values import require
from navigation import CollisionWorld, PlanningError

from .core.body import Body, Machine
from .core.clock import MOMENT, Clock, InProgress, Turn
from .core.compilation import notice_uncompiled
from .core.custom_code import Imports, supervised
from .core.entries import Blackout, Command, Start
from .core.events import (
    BlackoutBegan,
    BlackoutEnded,
    Commanded,
    FileNotice,
    TrialEnded,
    TrialStarted,
)
from .core.recorder import Event, Figure, Listener, Listeners, Scene, recording_to, rounded
from .core.scenario import TrialError, spot
from .core.stage import Closures, Stage, Triggers
from .machines.agv.agv import Agv
from .machines.gantry.robot import GantryRobot
from .machines.kinds import made_by, models_of
from .machines.outside import given_arguments, written_arguments
from .machines.traffic.traffic import Traffic
from .people.minds import Outside
from .people.person import Person, speed_of, with_figures
from .people.population import Population
from .people.tracks.recorded_walks import RecordedWalk, recorded_walks, with_everybody
from .record.finished import Finished
from .record.summary import summarise
from .runs.run import Run
from .safety.contacts import Collisions
from .safety.floor_contacts import FloorContacts
from .safety.laws import own_laws, with_new_laws
from .safety.referee import Referee
from .trials.checks import check, check_own_events
from .trials.counterfactual import counterfactual_error, counterfactual_of, difference
from .trials.feasibility import command_faults
from .trials.trial import Trial

if TYPE_CHECKING:
    from .orders.dispatcher import Dispatcher
    from .safety.fields.guard import FieldGuard

BY_COMMAND = "command"
"""Reason of stops by command."""


class Commander:
    """Carries out and records the commands of a stage at their times."""

    def __init__(self, stage: Stage, listener: Listener) -> None:
        self._stage = stage
        self._listener = listener
        self._people: Mapping[str, Person] = {}
        self._decisions = 0
        self._decided_at = -math.inf
        self._after: defaultdict[int, list[Command]] = defaultdict(list)
        """Calls that wait for a decision, by its number."""

    def begin(self, people: Iterable[Person]) -> None:
        """Count the decisions of external people from now on."""
        self._people = {person.name: person for person in people}
        for person in people:
            if isinstance(person.mind, Outside):
                person.mind.on_decision.append(self._decide)

    @property
    def decision(self) -> int | None:
        """Number of the last decision if the simulation is still at it, otherwise None."""
        return self._decisions if self._decided_at == self._stage.clock.now else None

    def _decide(self) -> None:
        self._decisions += 1
        self._decided_at = now = self._stage.clock.now
        for command in self._after.pop(self._decisions, ()):
            self._stage.clock.call_at(now, partial(self._carry_out, command), Turn.OUTSIDE)

    def give(self, command: Command) -> None:
        """Carry out `command` at its time: calls at once, others after all other events."""
        clock, turn = self._stage.clock, Turn.COMMAND if command.call is None else Turn.OUTSIDE
        if command.decision is not None and command.decision > self._decisions:
            self._after[command.decision].append(command)
            clock.call_at(command.at, partial(self._without_decision, command), Turn.COMMAND)
        else:
            clock.call_at(command.at, partial(self._carry_out, command), turn)

    def _without_decision(self, command: Command) -> None:
        """Carry out a call whose decision did not occur, because the trial has changed."""
        if command in (waiting := self._after.get(command.decision or 0, [])):
            waiting.remove(command)
            self._carry_out(command)

    def record(self, command: Command) -> None:
        """Record a command that takes effect now. Calls of people are no events, but their acts."""
        block, arguments = command.block, command.arguments
        self._listener.command(command)
        if command.person is not None:
            return
        self._stage.record(
            Commanded(
                send=command.send,
                to=None if command.to is None else spot(self._stage.floorplan, command.to),
                block=None if block is None else block.name,
                footprint=None if block is None else [*block.footprint.exterior.coords[:-1]],
                bottom=None if block is None else float(block.bottom),
                top=None if block is None else float(block.top),
                clear=command.clear,
                hold=command.hold,
                release=command.release,
                call=command.call,
                machine=command.machine,
                arguments=None if arguments is None else [[*pair] for pair in arguments.items()],
            )
        )

    def _carry_out(self, command: Command) -> None:
        stage = self._stage
        if command.call is not None:
            one = None if command.person is None else self._people[command.person]
            self._call(command.call, one or stage.machines[str(command.machine)], command)
        self.record(command)
        to = None if command.to is None else spot(stage.floorplan, command.to)
        if to is not None:
            for person in stage.people:
                if person.name == command.send:
                    person.send(to)
        if command.block is not None:
            stage.put_down(command.block)
        if command.clear is not None:
            stage.take_up(command.clear)
        if command.hold is not None:
            stage.machines[command.hold].stand_for(BY_COMMAND, True)
        if command.release is not None:
            stage.machines[command.release].stand_for(BY_COMMAND, False)

    def _call(self, method: str, one: Machine | Person, command: Command) -> None:
        try:
            getattr(one, method)(**given_arguments(one, command.arguments or {}))
        except (TypeError, ValueError, PlanningError) as why:
            at = f"{method} of {one.name} at t = {command.at:g} s"
            raise UserError(f"the command {at} cannot be carried out: {why}") from why


def schedule_blackouts(stage: Stage, blackouts: Iterable[Blackout]) -> None:
    """Schedule the blackouts of a trial."""
    for blackout in blackouts:
        stage.triggers.add(blackout.start, partial(_begin_blackout, stage, blackout))


def _begin_blackout(stage: Stage, blackout: Blackout) -> None:
    name, clock = blackout.machine, stage.clock
    stage.blind[name] += 1
    if stage.blind[name] == 1:
        stage.record(BlackoutBegan(machine=name))
        _sight_changed(stage, name)
    clock.call_at(clock.now + blackout.seconds, partial(_end_blackout, stage, name))


def _end_blackout(stage: Stage, name: str) -> None:
    stage.blind[name] -= 1
    if stage.blind[name] == 0:
        stage.record(BlackoutEnded(machine=name))
        _sight_changed(stage, name)


def _sight_changed(stage: Stage, name: str) -> None:
    stage.machines[name].sight_changed()
    for notify in stage.on_blackout:
        notify(name)


MOST_AT_ONCE, MOST_AT_ONCE_EACH = 3000, 100
"""Maximum number of events within a millisecond: a base, and an addition for each body."""

MOST_NAMED = 5
"""Number of kinds of events in the error about time that does not progress."""


_Given = ParamSpec("_Given")
_Returned = TypeVar("_Returned")


def _in_run(
    method: Callable[Concatenate[Simulation, _Given], _Returned],
) -> Callable[Concatenate[Simulation, _Given], _Returned]:
    """Activate the modules of a run in a method, and add the lines of their errors to messages."""

    @wraps(method)
    def guarded(
        simulation: Simulation, /, *given: _Given.args, **terms: _Given.kwargs
    ) -> _Returned:
        clock = simulation.clock
        with simulation._imports.active(), clock.under_way(), supervised(clock):
            return method(simulation, *given, **terms)

    return guarded


class Simulation(InProgress):
    """Simulation of one trial, run step by step.

    Call `advance` as often as needed, then `finish`. Nothing happens, and no listener is notified,
    before `start` or the first `advance`.

    Parameters
    ----------
    trial : Trial
        The trial.
    *listeners : Listener
        Listeners for events and motions.

    Raises
    ------
    TrialError
        If the trial is invalid.
    ControllerError
        If a custom controller cannot be imported.
    LawError
        If a custom law cannot be imported.

    Examples
    --------
    >>> simulation = sim.Simulation(sim.Trial.load("ariac2023"))
    >>> simulation.advance(10.0)
    >>> simulation.over
    False
    >>> simulation.finish().duration
    10.0
    """

    def __init__(self, trial: Trial, *listeners: Listener) -> None:
        self._cpu_begin = time.process_time()
        notice_uncompiled()
        self._imports = Imports()
        self.clock = Clock(busy=self._busy)
        self._assemble(trial, listeners)

    @_in_run
    def _assemble(self, trial: Trial, listeners: Iterable[Listener]) -> None:
        require(trial, Trial, "sim.Trial.load")
        check(trial)
        trial = with_everybody(trial)
        if any(own_laws(trial.rules)):
            trial = replace(trial, rules=with_new_laws(trial.rules))
        self.trial = trial
        self.events: list[Event] = []
        triggers = Triggers(self.clock)
        self._listener = Listeners(_Keeper(self.events), *listeners, _Reactor(triggers))
        self._over = self.clock.end()
        self._started = False
        people = with_figures(trial)
        walks = recorded_walks(trial)
        closures = Closures(trial.floorplan, trial.doors, trial.obstacles)
        self._stage = Stage(
            floorplan=trial.floorplan,
            rules=trial.rules,
            code_folder=trial.code_folder,
            end=trial.duration,
            clock=self.clock,
            record=recording_to(self._listener, lambda: self.clock.now),
            triggers=triggers,
            world=CollisionWorld(trial.floorplan),
            fastest=_fastest(people, walks),
            widest=_widest(trial),
            closures=closures,
        )
        self.world = self._stage.world
        self.machines = self._stage.machines
        for name, model in models_of(trial).items():
            self._stage.add(made_by(model, name, self._stage))
        # Random starts of people must avoid machines, of which the floorplan contains only AGVs.
        self._stage.place_machines()
        check_own_events(trial)
        self.referee = Referee(self._stage)
        self.dispatcher = self._make_dispatcher()
        self._commander = Commander(self._stage, self._listener)
        self.commands: list[Command] = [*trial.commands]
        self._company = Population(self._stage, people, self.referee, self._listener, walks)
        self.people = self._stage.people = self._company.people
        self._collisions = Collisions(self._stage, self.machines.values())
        self._floor_contacts = FloorContacts(self._stage, self.machines.values())
        self._guards = self._make_guards()
        self._traffic = Traffic(self._stage, self.machines.values() if trial.traffic else ())
        self.clock.most = MOST_AT_ONCE + MOST_AT_ONCE_EACH * len(self.bodies)
        self.scene = self._scene()
        self._commander.begin(self.people)
        for machine in self.machines.values():
            machine.on_command = partial(self._call_from_outside, machine)
        for person in self.people:
            person.on_command = partial(self._call_from_outside, person)

    @property
    def has_started(self) -> bool:
        """Whether the trial has started."""
        return self._started

    @_in_run
    def start(self) -> None:
        """Start the trial unless it has started."""
        if self._started:
            return
        self._started = True
        trial, stage = self.trial, self._stage
        self._listener.begin(self.scene)
        stage.record(TrialStarted(trial=trial.name, floorplan=trial.floorplan.name))
        for notice in trial.notices:
            stage.record(FileNotice(text=notice.message, field=notice.field, line=notice.line))
        for body in self.bodies if self._listener.wants_motions else ():
            body.on_record = self._listener.motion
        stage.begin()
        self._floor_contacts.begin()
        for machine in self.machines.values():
            machine.begin()
        for guard in self._guards.values():
            guard.begin()
        if self.dispatcher is not None:
            self.dispatcher.begin()
        self._end_with_jobs()
        self._company.begin()
        schedule_blackouts(stage, trial.every_blackout)
        for command in trial.commands:
            self._commander.give(command)

    @property
    def bodies(self) -> list[Body]:
        """People and machines in this order."""
        return [*(p.body for p in self.people), *(m.body for m in self.machines.values())]

    @property
    def gantry(self) -> GantryRobot | None:
        """First gantry, or None."""
        gantries = (m for m in self.machines.values() if isinstance(m, GantryRobot))
        return next(gantries, None)

    @property
    def agvs(self) -> list[Agv]:
        """AGVs."""
        return [m for m in self.machines.values() if isinstance(m, Agv)]

    def __repr__(self) -> str:
        return f"<Simulation of {self.trial.name!r} at t = {self.clock.now:g} s>"

    @property
    def over(self) -> bool:
        """Whether the trial has reached its end."""
        return self._over.triggered or self.clock.now >= self.trial.duration

    def person(self, name: str) -> Person:
        """Return a person.

        Parameters
        ----------
        name : str
            Name of the person.

        Raises
        ------
        ValueError
            If there is no person of that name. The message lists the known names.
        """
        for person in self.people:
            if person.name == name:
                return person
        names = [person.name for person in self.people]
        raise UserError(f"there is no person {name!r}; {suggestion(str(name), names)}")

    @_in_run
    def advance(self, until: float, *, enough: Callable[[], bool] | None = None) -> None:
        """Simulate all events before a time.

        Parameters
        ----------
        until : float
            Time in seconds, not before the current one.
        enough : callable, optional
            Function that is called after each event, and ends the advance if it returns True.

        Raises
        ------
        ValueError
            If the time is not a number, or is past.
        StandstillError
            If simulated time does not progress.
        """
        if not isinstance(until, Real) or math.isnan(until):
            raise UserError(f"advance(until) must be a time in seconds, not {until!r}")
        self.start()
        now = self.clock.now
        if rounded(float(until)) < rounded(now):
            raise UserError(f"advance({until:g}): the simulation is at t = {now:g} s already")
        if until > now and not self.over:
            self.clock.advance(min(float(until), self.trial.duration), enough)

    def branch(self, *listeners: Listener) -> Simulation:
        """Return another simulation of the same trial at the current time.

        It repeats the run with the commands that were given, which takes as long as the run did.
        Afterwards, both are independent. Controllers in Python start again in each run.

        Parameters
        ----------
        *listeners : Listener
            Listeners of the new simulation, for all of its events and motions.
        """
        other = Simulation(replace(self.trial, commands=tuple(self.commands)), *listeners)
        other.advance(self.clock.now)
        return other

    def command(self, command: Command) -> None:
        """Schedule an external command and record it.

        A trial with the same `commands` has the same run. Calls of the methods of machines and
        people between two advances are such commands, too.

        Parameters
        ----------
        command : Command
            The command. Its time is None for now.

        Raises
        ------
        TrialError
            If the command cannot be carried out.
        ValueError
            If its time is past.
        """
        require(command, Command)
        self.start()
        now = self.clock.now
        if command.time is not None and rounded(command.at) < rounded(now):
            raise UserError(f"a command for t = {command.time:g} s comes too late")
        command = replace(command, time=now if command.time is None else max(now, command.at))
        commands = sorted([*self.commands, command], key=lambda one: one.at)
        commanded = replace(self.trial, commands=tuple(commands))
        refuse("the command", command_faults(commanded), TrialError)
        self.commands[:] = commands
        self._commander.give(command)

    def _call_from_outside(
        self,
        one: Machine | Person,
        call: str,
        arguments: dict[str, Any],
        carry_out: Callable[[], Any],
    ) -> Any:
        """Carry out and record a call by the program that advances the simulation."""
        self.start()
        written = written_arguments(arguments)
        with self.clock.under_way():
            self.clock.advance(self.clock.now)  # what comes before the command in a repetition
            answer = carry_out()
            if not self.over:
                command = Command(
                    self.clock.now,
                    call=call,
                    machine=one.name if isinstance(one, Machine) else None,
                    person=one.name if isinstance(one, Person) else None,
                    arguments=written,
                    decision=self._commander.decision,
                )
                insort(self.commands, command, key=lambda one: one.at)
                self._commander.record(command)
        return answer

    def stop(self) -> None:
        """Stop the simulation after the current event. Any thread may call this at any time.

        The value of `over` does not change.
        """
        self.clock.stop()

    @property
    def stopped(self) -> bool:
        """Whether `stop` was called."""
        return self.clock.stopped

    @_in_run
    def finish(self) -> Run:
        """Return the run up to the current time."""
        self.start()
        interrupted = not self.over
        self.referee.close()
        for machine in self.machines.values():
            machine.close()
        self._traffic.close()
        self._stage.record(TrialEnded(interrupted=interrupted))
        motions = {body.name: body.track() for body in self.bodies}
        distancing = self._company.distancing
        summary = summarise(
            Finished(
                trial=self.trial,
                duration=self.clock.now,
                interrupted=interrupted,
                people=self.people,
                machines=self.machines,
                referee=self.referee,
                motions=motions,
                work=self.dispatcher.figures if self.dispatcher else {},
                collisions=self._collisions.count,
                contacts_with_floor=self._floor_contacts.count,
                guards=self._guards,
                waiting_times=self._traffic.waiting_times,
                traffic_deadlocks=self._traffic.deadlocks,
                deadlocks=self._company.deadlocks,
                people_too_near=distancing.count if distancing else 0,
                people_too_near_time=distancing.time if distancing else 0.0,
            )
        )
        if self.trial.counterfactual is not None:
            summary["counterfactual"] = None if interrupted else self._counterfactual(summary)
        cpu = time.process_time() - self._cpu_begin
        summary["cpu_seconds"] = round(cpu, 6)
        summary["realtime_factor"] = round(self.clock.now / cpu, 1) if cpu > 0 else None
        return Run(
            trial=replace(self.trial, commands=tuple(self.commands)),
            scene=self.scene,
            duration=self.clock.now,
            summary=summary,
            events=tuple(self.events),
            motions=motions,
            violations={
                (watch.pair.person.name, watch.pair.machine.name): tuple(watch.intervals)
                for watch in self.referee.watches
            },
            thoughts=tuple(self._company.thoughts),
            requirements={
                (watch.pair.person.name, watch.pair.machine.name): watch.requirement
                for watch in self.referee.watches
                if watch.plans is not None
            },
        )

    def _counterfactual(self, summary: dict[str, Any]) -> dict[str, Any]:
        """Run the trial without machines or people, and return what differs."""
        started = {name: one["started"] for name, one in summary["people"].items()}
        try:
            other = Simulation(counterfactual_of(self.trial, started))
        except InputError as why:
            raise counterfactual_error(why) from why
        other.advance(self.clock.now)
        changes: dict[str, Any] = rounded(difference(self.trial, summary, other.finish().summary))
        return changes

    def _busy(self) -> str:
        """Return the events recorded in this moment, in words, the most frequent first."""
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

    def _make_dispatcher(self) -> Dispatcher | None:
        workload, gantry = self.trial.workload, self.gantry
        if workload is None or gantry is None:
            return None
        from .orders.dispatcher import Dispatcher  # most trials have no orders
        from .orders.workload import Workload

        assert isinstance(workload, Workload)
        return Dispatcher(self._stage, workload, gantry, self._work_is_done, self.trial.seed)

    def _make_guards(self) -> dict[str, FieldGuard]:
        """Return the guard of each machine that has protective fields."""
        if not self.trial.fields:
            return {}
        from .safety.fields.guard import FieldGuard  # most trials have no fields

        people = [
            (person, person.walker.human.radius, self.referee.watches_of(person))
            for person in self._company.people
        ]
        guards = {
            name: FieldGuard(self._stage, self.machines[name], fields, people)
            for name, fields in self.trial.fields.items()
        }
        self._stage.on_blackout.append(
            lambda name: guards[name].sight_changed() if name in guards else None
        )
        return guards

    def _end_with_jobs(self) -> None:
        """End the run after all orders are submitted, if jobs of the gantry submit them."""
        orders = [job for job in self.trial.gantry.jobs if job.kind == "submit"]
        if orders and self.trial.workload is None:
            last = Start(event="order_submitted", count=len(orders))
            self._stage.triggers.add(last, self._work_is_done)

    def _work_is_done(self) -> None:
        if self.trial.until_submitted and not self._over.triggered:
            self._over.succeed()

    def _scene(self) -> Scene:
        """Return the scene, which stays the same during the run."""
        trial, human = self.trial, self.trial.floorplan.human
        return Scene(
            trial=trial.name,
            seed=trial.seed,
            floorplan=trial.floorplan,
            rules=trial.rules,
            people=tuple(
                Figure(
                    p.name,
                    personality=p.personality_name,
                    radius=p.radius or human.radius,
                    height=human.height,
                )
                for p in trial.people
            ),
            starts={body.name: body.state.position for body in self.bodies},
            machines=tuple(machine.shape for machine in self.machines.values()),
            passing=tuple(timed.obstacle for timed in trial.obstacles),
            controller=trial.gantry.controller_name if trial.floorplan.gantry else "",
            fields=trial.fields,
        )


def run(trial: Trial, *listeners: Listener) -> Run:
    """Run a trial to its end.

    Parameters
    ----------
    trial : Trial
        The trial.
    *listeners : Listener
        Listeners for events and motions.

    Returns
    -------
    Run
        The run.

    Raises
    ------
    TrialError
        If the trial is invalid.
    ControllerError, LawError, MindError
        If a custom controller, law or program fails.
    StandstillError
        If simulated time does not progress.
    ValueError
        If other custom code fails. The message includes the line.

    Examples
    --------
    >>> run = sim.run(sim.Trial.load("ariac2023"))
    >>> run.summary["penalties"]
    9
    """
    with frozen_collector():
        simulation = Simulation(trial, *listeners)
        simulation.advance(trial.duration)
        return simulation.finish()


def _fastest(trial: Trial, walks: Mapping[str, RecordedWalk]) -> float:
    """Return the highest top speed of people in the trial and on the floor, m/s."""
    usual = trial.floorplan.human.max_speed
    speeds = [speed_of(entry, usual) for entry in trial.people]
    return max([usual, *speeds, *(walk.top_speed for walk in walks.values())])


def _widest(trial: Trial) -> float:
    """Return the largest radius of people in the trial and on the floor, m."""
    return max(trial.floorplan.human.radius, *(entry.radius or 0.0 for entry in trial.people), 0.0)


def _in_words(event: Event) -> str:
    """Return the kind of an event and its participants."""
    who = [str(event[key]) for key in ("person", "with", "by", "agv", "job") if key in event]
    return f"{event['kind']} ({', '.join(who)})" if who else str(event["kind"])


class _Keeper(Listener):
    """Collects the events of a run."""

    def __init__(self, events: list[Event]) -> None:
        self._events = events

    def event(self, event: Event) -> None:
        self._events.append(event)


class _Reactor(Listener):
    """Triggers the consequences of events, after all other listeners were notified."""

    def __init__(self, triggers: Triggers) -> None:
        self._triggers = triggers

    def event(self, event: Event) -> None:
        self._triggers.notify(event)
