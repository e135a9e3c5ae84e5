"""The figures of a run, each declared once: summary, expectations, studies and tables follow."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from operator import attrgetter
from typing import Any, Literal

from floorplan.files.dataclass import dataclass

from ..core import events
from ..core.scenario import Scenario
from ..machines.kinds import may_be, short_laws
from ..orders.scope import has_conveyor, has_drops, has_faulty_parts, has_orders
from . import words
from .finished import CAUSES, Finished
from .social_metrics import DISTANCES, MOVEMENT, PROGRESS


@dataclass(frozen=True, kw_only=True)
class SummaryFigure:
    """One figure of a run.

    `path` is its place in the summary or the metrics. NAME in it is a name of the trial, and OTHER
    the name of another body. `of` computes it from a `Finished` run, and from the person below
    `people.NAME`. Parts of other figures need no `of`. Trials can expect numbers, flags and visits.

    `events` are the events behind the figure: their kind and their fields, with NAME for the name
    in `path` and VEHICLE for any kind of vehicle. With `instant`, the figure of that name beside it
    is its time. With `short`, it is also found by the name of the figure that contains it. It
    exists in trials for which `only` holds. Where `null` holds it has no value, and cannot be
    expected.

    `label` is its name for people, and `words` formats it for terminals. It is a column of studies
    unless `column` is False. Reports of studies compare it as a `measure`. "rare" measures appear
    only if they are not 0 everywhere. `worst` lists the rows with the least (1) or the most (-1) of
    it.
    """

    path: str
    meaning: str = ""
    unit: str = ""
    form: Literal["number", "flag", "visits", "text", "parts"] = "number"
    of: Callable[..., Any] | None = None
    events: tuple[type[events.EventKind], Mapping[str, Any]] | None = None
    instant: str = ""
    short: bool = False
    only: Callable[[Scenario], object] = lambda trial: True
    null: Callable[[Scenario], object] = lambda trial: False
    label: str = ""
    words: words.Words | None = None
    column: bool = True
    measure: Literal["", "plain", "chief", "rare"] = ""
    worst: int = 0


def _no_robot(trial: Scenario) -> bool:
    """Return True if no machine can be a robot."""
    machines = trial.machines.values()
    return trial.floorplan.gantry is None and not any(may_be("robot", one) for one in machines)


def _has_vehicles(trial: Scenario) -> bool:
    """Return True if there may be vehicles that set out: moved by the trial, or with orders."""
    ordered = trial.workload is not None and bool(trial.floorplan.lanes)
    own = any(may_be("vehicle", one) for one in trial.machines.values())
    return ordered or own or any(trial.agvs.values())


def _may_collide(trial: Scenario) -> bool:
    """Return True if there may be machines that come into each other's way."""
    return _has_vehicles(trial) or bool(trial.machines)


def _may_wait(trial: Scenario) -> bool:
    """Return True if there are several machines of the trial that wait for each other."""
    moving = len(trial.machines) + sum(map(bool, trial.agvs.values()))
    with_gantry = bool(trial.machines) and trial.floorplan.gantry is not None
    return trial.traffic and moving + with_gantry > 1


def _may_move(trial: Scenario) -> bool:
    """Return True if there may be machines that move."""
    return not _no_robot(trial) or _may_collide(trial)


def _may_touch(trial: Scenario) -> bool:
    """Return True if there are people, and machines that may come to where they are."""
    return bool(trial.people) and (not _no_robot(trial) or _has_vehicles(trial))


_of_orders = partial(SummaryFigure, only=has_orders)
_of_vehicles = partial(SummaryFigure, only=_has_vehicles)
_of_machines = partial(SummaryFigure, only=_may_collide)
_of_fields = partial(SummaryFigure, only=attrgetter("fields"))
_of_claims = partial(SummaryFigure, only=_may_wait)
_of_bodies = partial(SummaryFigure, only=_may_touch)
_of_faulty_parts = partial(SummaryFigure, only=has_faulty_parts)
_of_conveyor = partial(SummaryFigure, only=has_conveyor)
_of_drops = partial(SummaryFigure, only=has_drops)
_of_work = partial(SummaryFigure, only=attrgetter("has_work"))
_of_traffic = partial(SummaryFigure, only=attrgetter("has_traffic"))
_of_zones = partial(SummaryFigure, only=attrgetter("floorplan.zones"))
_of_several = partial(SummaryFigure, only=lambda trial: len(trial.people) > 1)
_of_distancing = partial(
    SummaryFigure,
    only=lambda trial: trial.rules.between_people is not None and len(trial.people) > 1,
)

PEOPLE = "people.NAME."


def _violations(prefix: str, fields: Mapping[str, Any]) -> Iterator[SummaryFigure]:
    """Yield the violations with the gantry by cause: of all people, or of one."""
    for cause, moved in zip(CAUSES, ("moving", "stationary"), strict=True):
        yield SummaryFigure(
            path=f"{prefix}violations.{cause}",
            label=f"violations, {cause}",
            meaning=f"violations with the {moved} gantry",
            events=(events.Violation, {**fields, "cause": cause}),
            measure="" if prefix else "plain",
        )


def _separation(prefix: str) -> Iterator[SummaryFigure]:
    """Yield the parts of the least separation, of all people or of one."""
    yield from _nearest(
        f"{prefix}minimum_separation",
        partial(SummaryFigure, null=_no_robot),
        label="least separation",
        meaning="minimum distance of a person to the gantry, as the rules measure",
        measure="" if prefix else "chief",
        worst=1,
    )


def _nearest_agv(prefix: str) -> Iterator[SummaryFigure]:
    """Yield the parts of the least distance to a moving vehicle, of all people or of one."""
    yield from _nearest(
        f"{prefix}nearest_agv",
        _of_vehicles,
        label="least distance to vehicles",
        meaning="minimum distance of a person to a moving vehicle, as the rules measure",
        measure="" if prefix else "plain",
        worst=0 if prefix else 1,
    )


def _nearest(
    path: str, figure: Callable[..., SummaryFigure], **distance: Any
) -> Iterator[SummaryFigure]:
    """Yield the parts of a least distance: the distance, its time, and the required distance."""
    part = partial(figure, instant="time")
    yield part(path=f"{path}.distance", unit="m", short=True, **distance)
    yield part(path=f"{path}.time", meaning="time of this distance", unit="s")
    meaning = "required distance at this time"
    yield part(path=f"{path}.required", meaning=meaning, unit="m")


def _least_margin(path: str, which: int, **value: Any) -> Iterator[SummaryFigure]:
    """Yield a least margin and its parts: its value, its time, person and machine."""
    figure = partial(SummaryFigure, null=lambda trial: not _may_touch(trial))
    part = partial(figure, instant="time")

    def whole(run: Finished) -> dict[str, float | str] | None:
        margin = run.margins[which]
        return None if margin is None else margin.figures

    yield figure(path=path, form="parts", of=whole, label=value["label"], words=words.margin)
    yield part(path=f"{path}.value", unit="m", short=True, worst=1, measure="plain", **value)
    yield part(path=f"{path}.time", meaning="time of this margin", unit="s")
    yield part(path=f"{path}.person", form="text", meaning="person of this margin")
    yield part(path=f"{path}.machine", form="text", meaning="machine of this margin")


def _approaches() -> Iterator[SummaryFigure]:
    """Yield the approaches of machines during violations: number, duration, and the worst."""
    figure = partial(SummaryFigure, null=lambda trial: not _may_touch(trial))
    part = partial(figure, instant="time")

    def whole(run: Finished) -> dict[str, Any]:
        worst = min(run.approaches, default=None)
        return {
            "count": len(run.approaches),
            "duration": sum(one.end - one.begin for one in run.approaches),
            "margin": None if worst is None else worst.margin,
            "time": None if worst is None else worst.time,
            "person": None if worst is None else worst.person,
            "machine": None if worst is None else worst.machine,
        }

    label = "approaches during violations"
    yield figure(path="approaches", form="parts", of=whole, label=label, words=words.approaches)
    yield part(
        path="approaches.count",
        label=label,
        meaning="times that a machine moved towards a person during a violation",
        short=True,
        measure="rare",
        worst=-1,
    )
    yield part(
        path="approaches.duration",
        label="time of approaches",
        meaning="duration of these approaches",
        unit="s",
        measure="rare",
    )
    yield part(path="approaches.margin", meaning="least margin during these approaches", unit="m")
    yield part(path="approaches.time", meaning="time of this margin", unit="s")
    yield part(path="approaches.person", form="text", meaning="person of this margin")
    yield part(path="approaches.machine", form="text", meaning="machine of this margin")


def _counterfactual() -> Iterator[SummaryFigure]:
    """Yield the differences to the same trial without machines, or without people."""
    figure = partial(SummaryFigure, only=attrgetter("counterfactual"))
    people = partial(SummaryFigure, only=lambda one: one.counterfactual == "without machines")
    machines = partial(SummaryFigure, only=lambda one: one.counterfactual == "without people")
    path = "counterfactual"
    label = "because of machines or people"
    yield figure(path=path, form="parts", label=label, words=words.differences)
    for prefix in (f"{path}.", f"{path}.people.NAME."):
        measure: Literal["", "plain"] = "" if "NAME" in prefix else "plain"
        yield people(
            path=f"{prefix}visits",
            label="visits because of machines",
            meaning="visits more than without machines",
            measure=measure,
            worst=0 if "NAME" in prefix else 1,
        )
        yield people(
            path=f"{prefix}distance_walked",
            label="walked because of machines",
            meaning="distance more than without machines",
            unit="m",
            measure=measure,
        )
        yield people(
            path=f"{prefix}time_standing",
            label="stood because of machines",
            meaning="time at rest more than without machines",
            unit="s",
            measure=measure,
        )
    yield machines(
        path=f"{path}.jobs_done",
        label="jobs because of people",
        meaning="jobs more than without people",
        measure="plain",
        worst=1,
    )
    for key, meaning in (
        ("gantry_idle_time", "idle time more than without people"),
        ("gantry_disabled_time", "disabled time more than without people"),
        ("protective_stop_time", "protective stops more than without people"),
    ):
        yield machines(path=f"{path}.{key}", meaning=meaning, unit="s")


def _metrics() -> Iterator[SummaryFigure]:
    """Yield the metrics of social navigation. `docs/metrics.md` defines them."""
    person, machine = "metrics.people.NAME.", "metrics.machines.NAME."
    for prefix, keys in (
        (person, (*MOVEMENT, *PROGRESS)),
        (person, ("social_work",)),
        (f"{person}distance_to.OTHER.", DISTANCES),
        (f"{person}distance_to_groups.OTHER.", DISTANCES),
        (machine, MOVEMENT),
        (machine, ("social_work",)),
        (f"{machine}distance_to_people.", DISTANCES),
        (f"{machine}distance_to_groups.OTHER.", DISTANCES),
    ):
        yield from (SummaryFigure(path=prefix + key) for key in keys)


_OF_THE_TRIAL = {
    "trial": "trial.name",
    "floorplan": "trial.floorplan.name",
    "rules": "trial.rules.name",
    "seed": "trial.seed",
}
_ORDER = (events.OrderSubmitted, {"order": "NAME"})

FIGURES: dict[str, SummaryFigure] = {
    figure.path: figure
    for figure in (
        *(
            SummaryFigure(path=path, form="text", of=attrgetter(of), column=False)
            for path, of in _OF_THE_TRIAL.items()
        ),
        SummaryFigure(
            path="duration",
            of=lambda run: run.duration,
            label="duration",
            meaning="simulated time",
            unit="s",
            measure="plain",
        ),
        SummaryFigure(
            path="interrupted",
            form="flag",
            of=lambda run: run.interrupted,
            meaning="whether the run was interrupted",
            column=False,
        ),
        SummaryFigure(
            path="penalties",
            of=lambda run: run.referee.penalties,
            label="penalties",
            meaning="violations that disabled the gantry",
            words=words.beside_robots(words.plain),
            events=(events.Violation, {"penalty": True}),
            measure="chief",
            worst=-1,
        ),
        SummaryFigure(
            path="violations",
            form="parts",
            of=lambda run: run.violations(),
            label="violations with the gantry",
            words=words.beside_robots(words.by_cause),
        ),
        *_violations("", {}),
        SummaryFigure(
            path="agv_violations",
            of=lambda run: run.agv_violations,
            label="violations with vehicles",
            meaning="violations with a moving vehicle",
            words=words.beside_vehicles,
            events=(events.Violation, {"cause": "VEHICLE"}),
            measure="rare",
        ),
        SummaryFigure(
            path="agv_teleports",
            of=lambda run: run.referee.agv_teleports,
            label="teleports by vehicles",
            meaning="teleports because of a vehicle",
            words=words.some,
            events=(events.Teleport, {"reason": "agv"}),
            measure="plain",
        ),
        SummaryFigure(
            path="protective_stops",
            of=lambda run: run.referee.protective_stops,
            label="protective stops",
            meaning="protective stops of all machines",
            words=words.stops,
            events=(events.ProtectiveStop, {}),
            measure="rare",
        ),
        SummaryFigure(
            path="protective_stop_time",
            of=lambda run: run.referee.protective_stop_time,
            label="protective stop time",
            meaning="duration of protective stops, all machines",
            unit="s",
            events=(events.ProtectiveStop, {}),
            measure="rare",
        ),
        _of_fields(
            path="field_stops",
            of=lambda run: run.of_all_fields("field_stops"),
            label="field stops",
            meaning="stops by protective fields, all machines",
            words=words.plain,
            events=(events.FieldStop, {}),
            measure="rare",
        ),
        _of_fields(
            path="field_stop_time",
            of=lambda run: run.of_all_fields("field_stop_time"),
            label="field stop time",
            meaning="duration of these stops, all machines",
            unit="s",
            words=words.seconds,
            events=(events.FieldStop, {}),
            measure="rare",
        ),
        _of_fields(
            path="field_slow_time",
            of=lambda run: run.of_all_fields("field_slow_time"),
            label="slow for warning fields",
            meaning="time at warning speed without stops, all machines",
            unit="s",
            words=words.seconds,
            events=(events.FieldSlowdown, {}),
            measure="rare",
        ),
        _of_bodies(
            path="contacts",
            of=lambda run: run.referee.contacts.count,
            label="contacts with machines",
            meaning="contacts of a robot or a moving vehicle with a person",
            words=words.some,
            events=(events.Contact, {"with": None}),
            measure="rare",
            worst=-1,
        ),
        SummaryFigure(
            path="contacts_with_floor",
            only=_may_move,
            of=lambda run: run.contacts_with_floor,
            label="contacts with the floor",
            meaning="contacts of a machine with an obstacle, a closed door or the boundary",
            words=words.some,
            events=(events.Contact, {"person": None}),
            measure="rare",
            worst=-1,
        ),
        _of_machines(
            path="collisions",
            of=lambda run: run.collisions,
            label="collisions of machines",
            meaning="collisions of two machines",
            words=words.some,
            events=(events.Collision, {}),
            measure="rare",
            worst=-1,
        ),
        _of_claims(
            path="waiting_time",
            of=lambda run: sum(run.waiting_times.values()),
            label="machines waited",
            meaning="time that machines waited for each other, all machines",
            unit="s",
            events=(events.MachineWaiting, {}),
            measure="rare",
        ),
        _of_claims(
            path="traffic_deadlocks",
            of=lambda run: run.traffic_deadlocks,
            label="deadlocks of machines",
            meaning="times that machines waited for each other and none could evade",
            words=words.some,
            events=(events.TrafficDeadlock, {}),
            measure="rare",
            worst=-1,
        ),
        SummaryFigure(
            path="gantry_disabled_time",
            of=lambda run: float(run.of_robots("disabled_time")),
            label="gantry disabled",
            meaning="time disabled by penalties",
            unit="s",
            words=words.beside_robots(words.seconds),
            events=(events.GantryDisabled, {}),
            measure="chief",
        ),
        SummaryFigure(
            path="gantry_idle_time",
            of=lambda run: float(run.of_robots("idle_time")),
            label="gantry idle",
            meaning="time neither moving, handling, disabled nor in a protective stop",
            unit="s",
            measure="plain",
        ),
        SummaryFigure(
            path="jobs_done",
            of=lambda run: run.of_robots("jobs_done"),
            label="jobs done",
            meaning="jobs done by the gantry and by free vehicles",
            words=words.jobs,
            events=(events.JobDone, {}),
            measure="chief",
            worst=1,
        ),
        _of_drops(
            path="parts_dropped",
            of=lambda run: run.of_robots("parts_dropped"),
            label="parts dropped",
            meaning="parts lost by the gripper",
            words=words.plain,
            events=(events.PartDropped, {}),
            measure="rare",
        ),
        _of_faulty_parts(
            path="parts_faulty",
            of=lambda run: run.work["parts_faulty"],
            label="parts found faulty",
            meaning="parts rejected by the quality check of kits",
            words=words.plain,
            events=(events.PartFaulty, {}),
            measure="rare",
        ),
        _of_conveyor(
            path="parts_missed",
            of=lambda run: run.work["parts_missed"],
            label="parts missed",
            meaning="parts that fell off the end of the conveyor",
            words=words.plain,
            events=(events.PartMissed, {}),
            measure="rare",
        ),
        _of_orders(
            path="orders",
            form="parts",
            of=lambda run: run.work["orders"],
            meaning="see [ARIAC trials](ariac.md#scores)",
        ),
        _of_orders(
            path="score",
            of=lambda run: run.work["score"],
            label="score",
            meaning="points for all orders",
            words=words.score,
            measure="chief",
        ),
        _of_orders(
            path="best_score",
            of=lambda run: run.work["best_score"],
            meaning="maximum points",
        ),
        _of_orders(path="orders.NAME", form="parts", label="order NAME", words=words.order),
        *(
            _of_orders(path=f"orders.NAME.{part}", events=_ORDER)
            for part in ("announced", "submitted", "time", "score")
        ),
        _of_work(
            path="tasks_done",
            of=lambda run: sum(person.worker.tasks_done for person in run.people),
            label="tasks done",
            meaning="tasks of all people, without breaks",
            words=words.plain,
            events=(events.TaskDone, {}),
            measure="chief",
            worst=1,
        ),
        _of_zones(
            path="zones",
            form="parts",
            of=lambda run: run.zones,
        ),
        _of_zones(
            path="zones.NAME.time_occupied",
            label="time in NAME",
            meaning="time of all people in the zone",
            unit="s",
            measure="plain",
        ),
        _of_zones(
            path="zones.NAME.time_too_close",
            label="too close in NAME",
            meaning="time in the zone below the required distance to a machine",
            unit="s",
            measure="rare",
            worst=-1,
        ),
        _of_zones(
            path="zones.NAME.entries",
            label="entries into NAME",
            meaning="entries of people into the zone",
            measure="plain",
        ),
        SummaryFigure(
            path="law_audit",
            form="parts",
            of=lambda run: [{**vars(short)} for short in short_laws(run.trial, own_laws=True)],
            label="stopping underestimated for",
            meaning="machines that may stop later than their law assumes",
            words=words.short_laws,
            column=False,
        ),
        SummaryFigure(
            path="distances_between",
            form="text",
            of=lambda run: run.trial.rules.between,
            meaning="surfaces, if the rules measure distances to machines between them",
            only=lambda trial: trial.rules.between == "surfaces",
            column=False,
        ),
        SummaryFigure(
            path="minimum_separation",
            form="parts",
            of=lambda run: run.nearest_of_all,
            label="least distance to gantry",
            words=words.nearest,
        ),
        SummaryFigure(
            path="machines.NAME", form="parts", label="NAME", words=words.machine, column=False
        ),
        *_separation(""),
        _of_vehicles(
            path="nearest_agv",
            form="parts",
            of=lambda run: run.nearest_agv,
            label="least distance to vehicle",
            words=words.nearest_agv,
        ),
        *_nearest_agv(""),
        *_least_margin(
            "least_margin",
            0,
            label="least margin",
            meaning="minimum of distance minus required distance",
        ),
        *_least_margin(
            "least_margin_moving",
            1,
            label="least margin, moving",
            meaning="the same while the machine moves",
        ),
        *_approaches(),
        _of_several(
            path="nearest_people",
            form="parts",
            of=lambda run: run.nearest_people,
            label="least gap between people",
            words=words.nearest_people,
        ),
        _of_several(
            path="nearest_people.distance",
            label="least distance between people",
            meaning="minimum distance between two bodies",
            unit="m",
            instant="time",
            worst=1,
        ),
        _of_several(
            path="nearest_people.time",
            meaning="time of this distance",
            unit="s",
            instant="time",
        ),
        _of_several(
            path="overlaps",
            of=lambda run: run.overlaps,
            label="overlaps",
            meaning="pairs of people whose bodies overlapped",
            measure="rare",
        ),
        _of_several(
            path="deadlocks",
            of=lambda run: run.deadlocks,
            label="deadlocks",
            meaning="deadlocks between people",
            events=(events.Deadlock, {}),
            measure="rare",
        ),
        _of_distancing(
            path="people_too_near",
            of=lambda run: run.people_too_near,
            label="encounters of people",
            meaning="times that two people came closer than `between_people`",
            words=words.plain,
            events=(events.PeopleTooNear, {}),
            measure="plain",
            worst=-1,
        ),
        _of_distancing(
            path="people_too_near_time",
            of=lambda run: run.people_too_near_time,
            label="time of encounters",
            meaning="duration of this, all pairs",
            unit="s",
            measure="plain",
        ),
        _of_traffic(
            path="entered",
            of=lambda run: sum(len(p.stays) - (not p.is_awaited) for p in run.people),
            label="people entered",
            meaning="entries of people at a source, or of recorded people",
            words=words.plain,
            events=(events.Entered, {}),
            measure="plain",
        ),
        _of_traffic(
            path="left",
            of=lambda run: sum(end < math.inf for p in run.people for _, end in p.stays),
            label="people left",
            meaning="exits of people at a sink, or of recorded people",
            words=words.plain,
            events=(events.Left, {}),
            measure="plain",
            worst=1,
        ),
        SummaryFigure(
            path=f"{PEOPLE}personality",
            form="text",
            of=lambda run, person: person.personality,
            label="personality",
            meaning="initial personality",
            words=words.program,
        ),
        SummaryFigure(
            path=f"{PEOPLE}started",
            of=lambda run, person: person.started_at,
            meaning="time of the start, or null",
            unit="s",
        ),
        _of_traffic(
            path=f"{PEOPLE}left",
            of=lambda run, person: person.left_at,
            meaning="time of leaving the floor, or null",
            unit="s",
            events=(events.Left, {"person": "NAME"}),
        ),
        SummaryFigure(
            path=f"{PEOPLE}visits",
            form="visits",
            of=lambda run, person: person.visits,
            label="visits",
            meaning="stations reached, in order",
            words=words.counted,
            events=(events.Arrived, {"person": "NAME"}),
            measure="plain",
        ),
        SummaryFigure(
            path=f"{PEOPLE}distance_walked",
            of=lambda run, person: run.distance_walked(person),
            label="walked",
            meaning="distance since the start, without teleports",
            unit="m",
            words=words.metres,
            measure="plain",
        ),
        SummaryFigure(
            path=f"{PEOPLE}time_standing",
            of=lambda run, person: run.time_standing(person),
            label="at rest",
            meaning="time at rest since the start",
            unit="s",
            words=words.seconds,
            measure="plain",
        ),
        SummaryFigure(
            path=f"{PEOPLE}replans",
            of=lambda run, person: person.walker.replans,
            label="replans",
            meaning="blocked paths for which another was found",
            words=words.plain,
            events=(events.Replanned, {"person": "NAME"}),
            measure="plain",
        ),
        _of_several(
            path=f"{PEOPLE}time_lost_to_others",
            of=lambda run, person: person.walker.traveller.time_lost(run.duration),
            label="delayed by others",
            meaning="time lost to other people on the way to a goal",
            unit="s",
            measure="rare",
        ),
        _of_work(
            path=f"{PEOPLE}tasks_done",
            of=lambda run, person: person.worker.tasks_done,
            label="tasks done",
            meaning="tasks done, without breaks",
            words=words.plain,
            events=(events.TaskDone, {"person": "NAME"}),
        ),
        _of_work(
            path=f"{PEOPLE}time_working",
            of=lambda run, person: person.worker.time_working,
            label="worked",
            meaning="time at tasks, without breaks",
            unit="s",
            words=words.seconds,
            measure="plain",
        ),
        _of_work(
            path=f"{PEOPLE}throughput",
            of=lambda run, person: person.worker.throughput,
            label="throughput",
            meaning="tasks per hour of shift, or since the start",
            unit="1/h",
            measure="chief",
            worst=1,
        ),
        SummaryFigure(
            path=f"{PEOPLE}violations",
            form="parts",
            of=lambda run, person: run.violations(person),
        ),
        *_violations(PEOPLE, {"person": "NAME"}),
        SummaryFigure(
            path=f"{PEOPLE}minimum_separation",
            form="parts",
            of=lambda run, person: run.nearest.get(person.name),
        ),
        *_separation(PEOPLE),
        _of_vehicles(
            path=f"{PEOPLE}nearest_agv",
            form="parts",
            of=lambda run, person: run.nearest_vehicles.get(person.name),
        ),
        *_nearest_agv(PEOPLE),
        *_counterfactual(),
        SummaryFigure(
            path="cpu_seconds", form="text", meaning="CPU time of the run", unit="s", column=False
        ),
        SummaryFigure(
            path="realtime_factor", form="text", meaning="simulated time per CPU time", column=False
        ),
        *_metrics(),
    )
}
"""Every figure by its path, in the order of the summary."""

COSTS = ("cpu_seconds", "realtime_factor")
"""Figures that differ between runs of the same trial."""
