"""Safety report of a single run: its assumptions, and the values of its template."""

from __future__ import annotations

import math
import platform
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NamedTuple

from floorplan import Floorplan, Zone
from navigation import Motion
from navigation.kernels import COMPILED
from navigation.separation import AnyLaw

from ..core.body import MachineShape
from ..core.entries import COMMANDS, UNSIGNED, SignOff, Start
from ..core.recorder import Scene
from ..core.rules import RuleSet
from ..core.scenario import ASSUMED, PersonEntry, Scenario
from ..core.schedule import Drawn, Duration, WorkTask, as_given
from ..core.wording import counted, listed, minus, significant
from ..machines.kinds import in_words, models_of, on_floor, short_laws
from ..record.incidents import (
    RISKS,
    Incident,
    incidents,
    risk,
    time_on_floor,
    time_too_close,
    worst_first,
)
from ..record.outcome import Outcome
from ..record.stops import MachineTimes, machine_times
from ..record.summary import figures_in_words
from ..record.warm_up import after_warm_up, contacts_of, zones_of
from .safety_fields import field_tables
from .safety_findings import (
    CATEGORIES,
    COUNTED,
    SIGNED_BY,
    counts,
    sign_off_rows,
    stops_in_tables,
    without_a_job,
)
from .safety_page import (
    MOST_INCIDENTS,
    exposure,
    floor_picture,
    risk_pictures,
    run_pictures,
    together,
)

NO_SOURCE = "no source given"

Row = tuple[str, ...]


def about(scene: Scene, scenario: Scenario | None) -> dict[str, Any]:
    """Return the assumptions in the form of the macros of `safety_parts.html`.

    `scenario` is the trial, or None for a recording.
    """
    plan = scene.floorplan
    there = {
        "obstacle": len(plan.obstacles),
        "station": len(plan.stations),
        "door": len(plan.doors),
        "zone": len(plan.zones),
        "AGV lane": len(plan.lanes),
        "gantry": int(plan.gantry is not None),
    }
    shared: dict[str, Any] = {
        "name": scene.trial,
        "plan": plan,
        "on_floor": ", ".join(counted(n, what) for what, n in there.items() if n),
        "picture": floor_picture(plan),
        "zones": [_zone(zone) for zone in plan.zones],
        "machines": list(_machines(scene, scenario)),
        "fields": field_tables(scene, None if scenario is None else models_of(scenario)),
    }
    if scenario is None:
        return {**shared, "bodies": _bodies(scene)}
    sources = _sources(scenario)
    return {
        **shared,
        "people": _people(scenario),
        "work": list(_work(scenario)),
        "changes": list(_changes(scenario)),
        "sources": [(name, text or NO_SOURCE) for name, text in sources.items()],
        "without_source": [name for name, text in sources.items() if not text],
        "short_stops": in_words(short) if (short := short_laws(scenario)) else "",
        "notices": [notice.message for notice in scenario.notices],
        "has_recorded": any(one.recorded is not None for one in scenario.people),
    }


def _zone(zone: Zone) -> Row:
    concerned = "everybody" if zone.concerns == ("*",) else ", ".join(zone.concerns)
    return (zone.name, f"{zone.area.area:,.1f}", ", ".join(_rules(zone)), concerned)


def _rules(zone: Zone) -> Iterator[str]:
    if zone.forbidden:
        yield "forbidden"
    if zone.max_speed is not None:
        yield f"at most {zone.max_speed:g} m/s"
    if zone.one_way is not None:
        yield minus("one way, towards ({:g}, {:g})".format(*zone.one_way))


def _machines(scene: Scene, scenario: Scenario | None) -> Iterator[Row]:
    """Yield sizes, top speeds and stopping distances, one line for equal machines."""
    models = on_floor(Scenario(scene.floorplan)) if scenario is None else models_of(scenario)
    groups: dict[Row, list[str]] = {}
    for shape in scene.machines:
        model = models.get(shape.name)
        stop = None if model is None else model.longest_stop(scene.floorplan)
        line: Row = (
            shape.kind,
            f"{shape.length:g} × {shape.width:g}, from {shape.bottom:g} to {shape.top:g} high",
            f"{shape.top_speed:.2f}",
            "not known" if stop is None else f"{stop[0]:.2f} s, {stop[1]:.2f} m",
            scene.rules.law_and_key_of(shape)[0],
        )
        groups.setdefault(line, []).append(shape.name)
    for line, names in groups.items():
        yield (listed(names), *line)


class LawInUse(NamedTuple):
    """A law with its keys and machines in words, and the reference points of the distance."""

    machines: str
    law: AnyLaw
    between: str


def laws_of(rules: RuleSet, machines: Iterable[MachineShape]) -> list[LawInUse]:
    """Return the laws of machines, each once."""
    laws: list[tuple[AnyLaw, str, dict[str, list[str]]]] = []
    for machine in machines:
        key, law = rules.law_and_key_of(machine)
        between = _between(rules, machine)
        same = next((keys for *other, keys in laws if other == [law, between]), None)
        if same is None:
            laws.append((law, between, same := {}))
        same.setdefault(key, []).append(machine.name)
    return [
        LawInUse("; ".join(f"{key}: {listed(names)}" for key, names in keys.items()), law, between)
        for law, between, keys in laws
    ]


def _between(rules: RuleSet, machine: MachineShape) -> str:
    """Return the reference points of the distance between a person and a machine."""
    if rules.between == "surfaces":
        return "surface of the machine to surface of the person"
    point = "centre" if rules.measured_at(machine) == (0.0, 0.0) else "point of the rules"
    return f"{point} of the machine to centre of the person"


def _sources(scenario: Scenario) -> dict[str, str]:
    """Return the sources of assumptions, empty for those that need one and have none."""
    sources = {**scenario.sources}
    if scenario.floorplan.source:
        sources.setdefault("floorplan", scenario.floorplan.source)
    return {name: sources.get(name, "") for name in _assumed(scenario)} | sources


def _assumed(scenario: Scenario) -> list[str]:
    """Return the keys of the assumptions of a trial that need a source."""
    people = scenario.people
    there = {
        "floorplan": True,
        "rules": True,
        "machines": bool(scenario.floorplan.lanes or scenario.floorplan.gantry),
        "radius": bool(people),
        "max_speed": any(one.recorded is None for one in people),
        "field_of_view": any(one.noticing.field_of_view is not None for one in people),
        "reaction_time": any(one.noticing.reaction_time is not None for one in people),
        "personality": any(one.recorded is None for one in people),
        "work": scenario.has_work,
        "recorded": any(one.recorded is not None for one in people),
    }
    return [name for name in ASSUMED if there[name]]


def _drawn(value: Drawn | None, otherwise: str = "–") -> str:
    """Return a figure, or its distribution, in words."""
    if value is None:
        return otherwise
    if isinstance(value, Duration):
        return _distribution(value)
    if isinstance(value, tuple):
        return f"uniform, {value[0]:g} … {value[1]:g}"
    return significant(value)


def _distribution(value: Duration) -> str:
    """Return a distribution in words."""
    figures = [significant(one) for one in value.values]
    match value.kind:
        case "fixed":
            return figures[0]
        case "uniform":
            return f"uniform, {figures[0]} … {figures[1]}"
        case "triangular":
            return f"triangular, {figures[0]} … {figures[2]}, mostly {figures[1]}"
        case "normal":
            return f"normal, mean {figures[0]}, standard deviation {figures[1]}"
        case "lognormal":
            return f"lognormal, median {figures[0]}, sd of the logarithm {figures[1]}"
        case _:
            return f"exponential, mean {figures[0]}"


def span(begin: float, end: float) -> str:
    """Return an interval of time as written in the trial."""
    return f"{as_given(begin)} – {'the end' if end == math.inf else as_given(end)}"


def _bodies(scene: Scene) -> list[Row]:
    groups: dict[Row, list[str]] = {}
    for one in scene.people:
        line = (Path(one.personality).stem, f"{one.radius:g}", f"{one.height:g}")
        groups.setdefault(line, []).append(one.name)
    return [(listed(names), *line) for line, names in groups.items()]


_HEADS = {
    "who": "who",
    "personality": "personality",
    "radius": "radius, m",
    "speed": "top speed, m/s",
    "acceleration": "acceleration, m/s²",
    "sight": "field of view, °",
    "occlusion": "things hide others",
    "reaction": "reaction, s",
    "lag": "lag of the agent, s",
    "start": "from",
    "work": "work",
}


def _people(scenario: Scenario) -> dict[str, Sequence[Any]]:
    """Return a table of people without empty columns, one line for equal people."""
    groups: dict[Row, list[str]] = {}
    for one in scenario.people:
        line = tuple(_about(one, scenario.floorplan).values())
        groups.setdefault(line, []).append(one.name)
    rows = [(listed(names), *line) for line, names in groups.items()]
    heads = [*_HEADS.values()]
    shown = [k for k in range(len(heads)) if {row[k] for row in rows} - {"–"}]
    return {"heads": [heads[k] for k in shown], "rows": [[row[k] for k in shown] for row in rows]}


def _about(one: PersonEntry, plan: Floorplan) -> Mapping[str, str]:
    human = plan.human
    recorded = one.recorded
    if recorded is not None:
        where = "a motion" if isinstance(recorded, Motion) else recorded.file
        none = ("speed", "acceleration", "sight", "occlusion", "reaction", "lag")
        return {
            "personality": f"recorded: {where}",
            "radius": significant(one.radius or human.radius),
            **dict.fromkeys(none, "–"),
            "start": _start(one.start),
            "work": "–",
        }
    changes = "".join(f", then {Path(c.personality_name).stem}" for c in one.changes)
    return {
        "personality": Path(one.personality_name).stem + changes,
        "radius": significant(one.radius or human.radius),
        "speed": _drawn(one.max_speed, significant(human.max_speed)),
        "acceleration": significant(one.max_acceleration or human.max_acceleration),
        "sight": _drawn(one.noticing.field_of_view),
        "occlusion": "yes" if one.noticing.occlusion else "–",
        "reaction": _drawn(one.noticing.reaction_time),
        "lag": _drawn(one.agent_lag),
        "start": _start(one.start) if one.source is None else f"comes in, {one.source.rate:g}/s",
        "work": "; ".join(_duties(one)) or "–",
    }


def _start(start: Start) -> str:
    if start.time is not None:
        return f"{start.time:g} s" if start.time else "–"
    if start.order_submitted is not None:
        return f"order {start.order_submitted}"
    if start.part_placed is not None:
        return "a part is placed"
    return f"event {start.event}"


def _duties(one: PersonEntry) -> Iterator[str]:
    yield from one.work
    if one.schedule:
        yield f"{len(one.schedule)} on a schedule of their own"
    for begin, end in one.shifts:
        yield f"shift {span(begin, end)}"
    for each in one.breaks:
        yield f"break at {as_given(each.time)}"


def _work(scenario: Scenario) -> Iterator[Row]:
    alike: dict[tuple[str, str, str, bool], list[WorkTask]] = {}
    for name, work_list in scenario.work.items():
        for task in work_list.tasks:
            key = (name, task.name or "–", _distribution(task.duration), task.every is not None)
            alike.setdefault(key, []).append(task)
    for (name, task_name, length, _), tasks in alike.items():
        stations = listed([*dict.fromkeys(task.at for task in tasks)])
        when = _often(tasks, scenario.work[name].repeat)
        yield name, task_name, stations, length, when, _range([task.priority for task in tasks])


def _often(tasks: Sequence[WorkTask], repeat: bool) -> str:
    """Return the times and repetitions of tasks in words."""
    words = []
    if any(task.time for task in tasks):
        words.append(f"from {_range([task.time for task in tasks])} s on")
    intervals = [task.every for task in tasks if task.every is not None]
    if intervals:
        words.append(f"every {_range(intervals)} s")
    counts = [task.count for task in tasks if task.count is not None]
    if counts:
        words.append(f"{_range(counts)} times")
    if repeat and not intervals:
        words.append("again as soon as done")
    return ", ".join(words) or "once"


def _range(figures: Sequence[float]) -> str:
    """Return the range of some figures in words."""
    low, high = min(figures), max(figures)
    return significant(low) if low == high else f"{significant(low)} … {significant(high)}"


def _changes(scenario: Scenario) -> Iterator[Row]:
    """Yield the changes on the floor during a trial."""
    for name, times in scenario.doors.items():
        how = "open" if times.closed is None else "closed"
        yield from ((name, how, span(*interval)) for interval in times.intervals)
    for one in scenario.obstacles:
        yield from ((one.obstacle.name, "is there", span(*interval)) for interval in one.there)
    for each in scenario.every_blackout:
        begins = f"{each.start.time:g} s" if each.start.time is not None else "an event"
        yield each.machine, f"sees nobody for {each.seconds:g} s", f"from {begins} on"
    for command in scenario.commands:
        wanted = [(key, getattr(command, key)) for key in COMMANDS]
        wanted.append((command.call or "", command.machine))
        key, target = next((key, one) for key, one in wanted if one is not None)
        yield str(getattr(target, "name", target)), f"command: {key}", f"{command.time:g} s"


LIBRARIES = ("numpy", "shapely", "ompl", "python-fcl", "ruckig", "simpy")
"""Packages that may affect the last digits of figures."""

ASSUMED_FIGURES = ("personality",)
"""Figures of people that the section on assumptions contains."""


def software() -> list[tuple[str, str]]:
    """Return the software that computed the figures."""
    kernels = "compiled" if COMPILED else "not compiled"
    return [
        ("Floorwalker", f"{_version('floorwalker')}, kernels {kernels}"),
        ("Python", f"{platform.python_version()} ({platform.python_implementation()})"),
        ("platform", f"{platform.system()} {platform.machine()}"),
        ("libraries", ", ".join(f"{name} {_version(name)}" for name in LIBRARIES)),
    ]


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # built into the system
        return "unknown"


def run_report(
    run: Outcome,
    scenario: Scenario | None,
    *,
    digests: Mapping[str, str],
    verdicts: Sequence[tuple[str, bool]] = (),
    warm_up: float = 0.0,
    sign_off: SignOff = UNSIGNED,
) -> dict[str, Any]:
    """Return the values of `safety_run.html`. `scenario` is the trial, None for a recording.

    `digests` are digests of the inputs, and `verdicts` are expectations and whether they were met.
    The time before `warm_up` (s) is omitted.
    """
    whole, run = run, after_warm_up(run, warm_up)
    worst, times = worst_first(incidents(run)), machine_times(run)
    scene = run.scene
    zones = run.summary.get("zones", {}) if run is whole else zones_of(run)
    near, there = time_too_close(run), time_on_floor(run)
    described = about(scene, scenario)
    maps = {of: risk(run, of) for of in RISKS} if scene.people and scene.machines else {}
    return {
        "scene": scene,
        "rules": scene.rules,
        "duration": run.duration,
        "on_floor": there,
        "near": near,
        "worst": worst,
        "contacts": contacts_of(run),
        "most_incidents": MOST_INCIDENTS,
        "led_to": together(worst),
        "verdicts": [("met" if met else "not met", words) for words, met in verdicts],
        "about": described,
        "trials": [described] if scenario else [],
        "notices": [] if scenario else [e["text"] for e in whole.events if e["kind"] == "notice"],
        "held": laws_of(scene.rules, scene.machines),
        **_summary(run),
        "maps": risk_pictures(run.floorplan, scene.machines, maps),
        "exposed": exposure(run.floorplan, zones, there, near),
        "shown": run_pictures(run, worst, since=warm_up),
        "warm_up": warm_up,
        "compared_counts": _compared_counts(whole, run, worst, times),
        "stops": stops_in_tables(times),
        "without_a_job": without_a_job(times, len(scene.people)),
        "sign_off": [*sign_off_rows(sign_off)],
        "signed_by": SIGNED_BY,
        "software": software(),
        "digests": [*digests.items()],
    }


def _compared_counts(
    whole: Outcome, run: Outcome, worst: Sequence[Incident], times: Sequence[MachineTimes]
) -> list[Row]:
    """Return counts after the warm-up and in the whole run, or nothing without a warm-up."""
    if run is whole:
        return []
    after = counts(run, worst, times)
    before = counts(whole, incidents(whole), machine_times(whole))
    categories = {one.category for one in run.scene.machines}
    left_out = {COUNTED[k] for k, one in enumerate(CATEGORIES) if one not in categories}
    rows = zip(COUNTED, after, before, strict=True)
    return [row for row in rows if row[0] not in left_out]


def _summary(run: Outcome) -> dict[str, Any]:
    """Return the figures of a run, and a table of the figures of people."""
    of_people: dict[str, dict[str, str]] = {person.name: {} for person in run.scene.people}
    others = []
    for line, amount in figures_in_words(run.summary, in_short=False) if run.summary else ():
        name, _, label = line.partition(": ")
        if name not in of_people:
            others.append((line, amount))
        elif label not in ASSUMED_FIGURES:
            of_people[name][label] = amount
    labels = [*dict.fromkeys(label for figures in of_people.values() for label in figures)]
    rows = [
        (name, *(figures.get(label, "–") for label in labels))
        for name, figures in of_people.items()
        if labels
    ]
    return {"summary": others, "people": {"heads": ("who", *labels), "rows": rows}}
