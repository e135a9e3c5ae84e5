"""Goals that people cannot reach, proved from the connected parts of the free space."""

from __future__ import annotations

from collections.abc import Iterator

from floorplan import Point
from floorplan.files.problems import Fault, Place
from navigation import CollisionWorld

from ..core.scenario import PersonEntry, Scenario, spot
from ..core.stage import Closures
from ..people.programs import EXTERNAL

EMPLOYED = "worker"
"""Built-in personality that only goes to its tasks, if it has any."""


class Reachability:
    """Proofs that people cannot reach goals, independent of AGVs and other people.

    They include forbidden zones, one-way gates, and doors and obstacles that are closed or present
    throughout the trial.
    """

    def __init__(self, trial: Scenario) -> None:
        self._trial = trial
        closures = Closures(trial.floorplan, trial.doors, trial.obstacles)
        always = closures.at(0.0)
        for t in closures.changes(trial.duration):
            always = {name: one for name, one in closures.at(t).items() if name in always}
        height = trial.floorplan.human.height
        self._closed = {
            name: one.footprint for name, one in always.items() if one.overlaps(0.0, height)
        }
        self._worlds: dict[tuple[str, ...], CollisionWorld] = {}

    def is_cut_off(self, person: PersonEntry, goal: Point) -> bool:
        """Return whether a free `goal` (m) is proved to be out of reach of a person."""
        plan, world = self._trial.floorplan, self._world_of(person.name)
        radius, home = person.radius or plan.human.radius, person.home_on(plan)
        begins = [None if home is None else home.position]
        if person.source is not None or person.at is not None:
            source = person.source
            start = spot(plan, source.at, person.radius) if source else person.place_on(plan)
            # A person who is put into the safe zone continues from there.
            begins = [start, *(begins if self._trial.rules.person == "teleport" else ())]
        space = world.free_space(radius)
        return space.piece_of(goal) is not None and all(
            begin is not None
            and space.piece_of(begin) is not None
            and not world.reaches(begin, goal, radius)
            for begin in begins
        )

    def _world_of(self, name: str) -> CollisionWorld:
        plan = self._trial.floorplan
        zones = [zone for zone in plan.zones if zone.forbidden and zone.is_about(name)]
        gates = [gate for gate in plan.one_ways if gate.is_about(name)]
        rules = (*(zone.name for zone in zones), *(gate.name for gate in gates))
        if rules not in self._worlds:
            closed = self._closed | {zone.name: zone.area for zone in zones}
            self._worlds[rules] = CollisionWorld(plan, gates=gates).as_if(
                closed, away=[lane.name for lane in plan.lanes]
            )
        return self._worlds[rules]


def unreachable_goals(trial: Scenario) -> Iterator[Fault]:
    """Yield the named goals that the person, or all people of the trial, cannot reach."""
    proofs = Reachability(trial)
    for place, people, name in _named_goals(trial):
        goal = spot(trial.floorplan, name, people[0].radius)
        if goal is not None and all(proofs.is_cut_off(person, goal) for person in people):
            who = ", ".join(person.name for person in people)
            yield f"{who} cannot reach {name if isinstance(name, str) else goal}", place


def _named_goals(trial: Scenario) -> Iterator[tuple[Place, list[PersonEntry], Point | str]]:
    """Yield the places of goals in a trial, with the people who go there."""
    walking = [(n, person) for n, person in enumerate(trial.people) if person.recorded is None]
    for name, work_list in trial.work.items():
        if workers := [person for _, person in walking if name in person.work]:
            for k, task in enumerate(work_list.tasks):
                yield ("work", name, "tasks", k, "at"), workers, task.at
    for n, person in walking:
        for key, tasks in (("schedule", person.schedule), ("breaks", person.breaks)):
            for k, task in enumerate(tasks):
                yield ("people", n, key, k, "at"), [person], task.at
        if person.sink is not None:
            yield ("people", n, "sink"), [person], person.sink
    for k, command in enumerate(trial.commands):
        if command.to is not None:
            sent = [person for _, person in walking if person.name == command.send]
            yield ("commands", k, "to"), sent, command.to


def unreachable_stations(trial: Scenario) -> Iterator[Fault]:
    """Yield the people whose programs may choose a station that they cannot reach."""
    proofs = Reachability(trial)
    for k, person in enumerate(trial.people):
        tasks = [*person.schedule, *(task for one in person.work for task in trial.work[one].tasks)]
        is_free = not (tasks and person.personality == EMPLOYED)
        if person.recorded is not None or person.personality == EXTERNAL:
            continue
        cut_off = [
            station.name
            for station in trial.floorplan.stations
            if (is_free or any(task.at == station.name for task in tasks))
            and proofs.is_cut_off(person, station.position)
        ]
        if cut_off:
            yield f"{person.name} cannot reach {', '.join(cut_off)}", ("people", k)
