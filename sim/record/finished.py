"""Measurement of a simulation at its end."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from typing import Any, NamedTuple

from floorplan import UserError
from floorplan.files.dataclass import dataclass
from navigation import Motion, Moving, when
from navigation.kernels.odometer import Odometer
from navigation.kernels.pieces import walked_and_stood
from navigation.measures import Nearest, nearest_pair
from navigation.monitor import least_over

from ..core.body import Category, Machine
from ..core.scenario import Scenario
from ..people.person import Person
from ..safety.approaches import Approach, approaches
from ..safety.fields.guard import FieldGuard
from ..safety.margins import (
    Encountered,
    Margin,
    RecordedRequirement,
    Span,
    least_margins,
)
from ..safety.monitors import SeparationMonitor
from ..safety.referee import Referee
from .sampling import Stay, zone_exposures

CAUSES = ("gantry", "person")
"""Causes of a violation with a gantry: the body that moved."""

CATEGORIES: tuple[Category, ...] = ("robot", "vehicle")
"""Categories of machines whose distances to people are monitored."""


class _Monitored(NamedTuple):
    """Monitor of a person and a machine, their motions, and spans (s).

    In these spans the person is on the floor, and a vehicle moves.
    """

    watch: SeparationMonitor
    person: Motion
    machine: Motion
    spans: list[Span]


@dataclass(frozen=True, kw_only=True)
class Finished:
    """A simulation at its end: `duration` in seconds, `work` with the figures of orders."""

    trial: Scenario
    duration: float
    interrupted: bool
    people: Sequence[Person]
    machines: Mapping[str, Machine]
    referee: Referee
    motions: Mapping[str, Motion]
    work: Mapping[str, Any]
    guards: Mapping[str, FieldGuard] = field(default_factory=dict)
    collisions: int = 0
    contacts_with_floor: int = 0
    waiting_times: Mapping[str, float] = field(default_factory=dict)
    """Time (s) for which each machine has waited for others."""
    traffic_deadlocks: int = 0
    deadlocks: int = 0
    people_too_near: int = 0
    people_too_near_time: float = 0.0

    def violations(self, person: Person | None = None) -> dict[str, int]:
        """Return the number of violations with the gantry by cause, of one person or all."""
        counted = self.referee.violations.items()
        return {
            cause: sum(
                count
                for (name, why), count in counted
                if why == cause and (person is None or name == person.name)
            )
            for cause in dict.fromkeys((*CAUSES, *sorted(self._kinds("robot"))))
        }

    @property
    def agv_violations(self) -> int:
        """Number of violations with vehicles."""
        kinds = self._kinds("vehicle")
        return sum(n for (_, cause), n in self.referee.violations.items() if cause in kinds)

    @cached_property
    def nearest(self) -> dict[str, dict[str, float]]:
        """Least distance (m) of each started person to a gantry, as the rules measure.

        With its `time` (s), and the `required` distance then (m).
        """
        return {person: figures for person, (figures, _) in self._nearest("robot").items()}

    def _nearest(self, category: Category) -> dict[str, tuple[dict[str, float], Machine]]:
        """Return the least distance of each started person, and the machine of the category."""
        nearest: dict[str, tuple[dict[str, float], Machine]] = {}
        for watch, one, other, spans in self._together(category):
            person, machine = watch.pair.person.name, watch.pair.machine
            measured = other.translated(*self.trial.rules.measured_at(machine.shape))
            if not spans:
                continue
            time, distance = least_over(None, one, measured, spans, watch.pair.shapes)
            if person not in nearest or distance < nearest[person][0]["distance"]:
                # A violation may end in a teleport, so the motion before it counts.
                required = watch.required_before(time, one, other)
                figures = {"distance": distance, "time": time, "required": required}
                nearest[person] = figures, machine
        return nearest

    @property
    def nearest_of_all(self) -> dict[str, float] | None:
        """Least of the distances in `nearest`, or None if there is none."""
        return min(self.nearest.values(), key=lambda least: least["distance"], default=None)

    @cached_property
    def nearest_vehicles(self) -> dict[str, dict[str, Any]]:
        """Least distance (m) of each person to a moving vehicle, as the rules measure.

        With its `time` (s), the `required` distance then (m), and the `agv`.
        """
        return {
            person: {**figures, "agv": machine.name}
            for person, (figures, machine) in self._nearest("vehicle").items()
        }

    @property
    def nearest_agv(self) -> dict[str, Any] | None:
        """Least of the distances in `nearest_vehicles` with its person, None if there is none."""
        nearest = self.nearest_vehicles.items()
        name, least = min(nearest, key=lambda one: one[1]["distance"], default=("", None))
        return None if least is None else {**least, "person": name}

    @cached_property
    def margins(self) -> tuple[Margin | None, Margin | None]:
        """Least margin (m) while violations count, and the least while the machine moves."""
        return least_margins(beside for beside, _ in self._encountered)

    @cached_property
    def approaches(self) -> list[Approach]:
        """Approaches of machines during violations, in order of time."""
        all_approaches = (
            one for beside, during in self._encountered for one in approaches(beside, during)
        )
        return sorted(all_approaches, key=lambda one: (one.begin, one.person, one.machine))

    @cached_property
    def _encountered(self) -> list[tuple[Encountered, list[Span]]]:
        """Each person beside each machine, with the violations of the two."""
        return [
            (
                Encountered(
                    watch.pair.person.name,
                    watch.pair.machine.name,
                    watch.law if watch.plans is None else RecordedRequirement(watch.requirement),
                    one,
                    other.translated(*self.trial.rules.measured_at(watch.pair.machine.shape)),
                    watch.pair.shapes,
                    spans,
                    spans if category == "vehicle" else self._moving(watch, spans),
                ),
                watch.intervals,
            )
            for category in CATEGORIES
            for watch, one, other, spans in self._together(category)
        ]

    def _moving(self, watch: SeparationMonitor, spans: Iterable[Span]) -> list[Span]:
        """Return the parts of spans in which a machine moves, as the rules define it."""
        motion, shapes = self.motions[watch.pair.machine.name], watch.pair.shapes
        moving = Moving(reach=0.0 if shapes is None else shapes.reach)
        return [part for span in spans for part in when(moving, motion, motion, *span)]

    def _together(self, category: Category) -> Iterator[_Monitored]:
        """Yield each person beside each machine of a category."""
        stays = {person.name: self._stays(person) for person in self.people}
        drives: dict[str, list[tuple[float, float]]] = {}
        for watch in self.referee.watches:
            person, machine = watch.pair.person.name, watch.pair.machine
            if machine.shape.category != category or not stays[person]:
                continue
            spans = stays[person]
            if category == "vehicle":
                if machine.name not in drives:
                    drives[machine.name] = self._moving(watch, [(0.0, self.duration)])
                pairs = itertools.product(spans, drives[machine.name])
                cut = [(max(a, begin), min(b, end)) for (begin, end), (a, b) in pairs]
                spans = [(a, b) for a, b in cut if a < b]
            motions = self.motions[person], self.motions[machine.name]
            yield _Monitored(watch, *motions, spans)

    def _stays(self, person: Person) -> list[tuple[float, float]]:
        """Return the times (s) for which a person was on the floor after the start."""
        since = math.inf if person.started_at is None else person.started_at
        cut = ((max(begin, since), min(end, self.duration)) for begin, end in person.stays)
        return [(begin, end) for begin, end in cut if begin <= end]

    @cached_property
    def among_people(self) -> Nearest | None:
        """Nearest encounter of two people, or None if no two were there at the same time."""
        return nearest_pair(
            [self.motions[person.name] for person in self.people],
            [person.walker.human.radius for person in self.people],
            [person.walker.human.max_speed for person in self.people],
            0.0,
            self.duration,
            [person.stays for person in self.people],
        )

    @property
    def nearest_people(self) -> dict[str, Any] | None:
        """Least distance between the bodies of two people (m), its time (s), and their names.

        None if no two were on the floor at the same time.
        """
        encounter = self.among_people
        if encounter is None:
            return None
        between = [self.people[k].name for k in encounter.pair]
        return {"distance": encounter.distance, "time": encounter.time, "between": between}

    @property
    def overlaps(self) -> int:
        """Number of pairs of people whose bodies overlapped."""
        return 0 if self.among_people is None else self.among_people.overlaps

    @property
    def zones(self) -> dict[str, dict[str, float]]:
        """Exposure of people in each zone of the floor, by name."""
        stays = [
            Stay(
                self.motions[person.name],
                span,
                [
                    interval
                    for watch in self.referee.watches
                    if watch.pair.person is person
                    for interval in watch.intervals
                ],
            )
            for person in self.people
            for span in self._stays(person)
        ]
        return zone_exposures(self.trial.floorplan.zones, stays)

    @cached_property
    def of_machines(self) -> dict[str, dict[str, Any]]:
        """Figures of each machine by name. `UserError` if they cannot be written as JSON."""
        all_figures = {}
        for name, machine in self.machines.items():
            all_figures[name] = machine.figures(self.motions[name], self.duration)
            try:
                json.dumps(all_figures[name], allow_nan=False)
            except (TypeError, ValueError) as why:
                raise UserError(f"the figures of the machine {name!r}: {why}") from why
            if not isinstance(all_figures[name], dict):
                message = f"expected a dict, found {all_figures[name]!r}"
                raise UserError(f"the figures of the machine {name!r}: {message}")
            if name in self.waiting_times:
                all_figures[name] = {**all_figures[name], "waiting_time": self.waiting_times[name]}
        return all_figures

    @cached_property
    def of_fields(self) -> dict[str, dict[str, float]]:
        """Figures of protective fields, by the name of the machine."""
        return {name: guard.figures for name, guard in self.guards.items()}

    def of_all_fields(self, figure: str) -> float:
        """Return the sum of a figure of protective fields over all machines."""
        return sum(figures[figure] for figures in self.of_fields.values())

    def of_robots(self, figure: str) -> Any:
        """Return the sum of a figure over all robots."""
        return sum(figures.get(figure, 0) for figures in self.of_machines.values())

    def _kinds(self, category: Category) -> set[str]:
        shapes = (machine.shape for machine in self.machines.values())
        return {shape.kind for shape in shapes if shape.category == category}

    def distance_walked(self, person: Person) -> float:
        """Return the distance (m) that a person has walked since the start, without teleports."""
        return self._walks[person.name][0]

    def time_standing(self, person: Person) -> float:
        """Return the time (s) for which a person has stood since the start."""
        return self._walks[person.name][1]

    @cached_property
    def _walks(self) -> dict[str, tuple[float, float]]:
        return {person.name: self._walked_and_stood(person) for person in self.people}

    def _walked_and_stood(self, person: Person) -> tuple[float, float]:
        stays, motion = self._stays(person), self.motions[person.name]
        if not stays:
            return 0.0, 0.0
        walked = walked_and_stood(motion.table, stays[0][0], math.inf)[0]
        stood = sum(walked_and_stood(motion.table, *stay)[1] for stay in stays)
        if person.is_recorded:
            # Pieces of recorded people are curved, so their speed is integrated.
            walked = Odometer(motion).reading(self.duration)
        return walked, stood
