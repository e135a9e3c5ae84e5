"""Assumptions of a safety report: floor, machines, separation laws and people."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup, escape

from floorplan import Floorplan, Zone
from navigation import ApproachLaw, FixedDistance, IntegralLaw, Motion, Scaled, SeparationLaw
from navigation.separation import AnyLaw

from ...core.body import MachineShape
from ...core.entries import Drawn, Duration, Start, WorkTask, as_given
from ...core.recorder import Scene
from ...core.rules import RuleSet
from ...core.scenario import ASSUMED, PersonEntry, Scenario
from ...core.stage import MachineModel
from ...record.incidents import CELL
from ...record.sampling import MOMENT
from ...safety.laws import OwnLaw
from .page import Cell, Facts, Points, ReportTable, listed, minus, plain

_T1, _T2 = Markup("T<sub>1</sub>"), Markup("T<sub>2</sub>")
_HUMAN, _ROBOT = Markup("v<sub>H</sub>"), Markup("v<sub>R</sub>")


@dataclass(frozen=True)
class LawSheet:
    """A law: its name and source, its formula, and each term: symbol, value, meaning."""

    name: str
    formula: Markup
    terms: tuple[tuple[Markup, str, str], ...]


def law_sheet(law: AnyLaw) -> LawSheet:
    """Return what there is to say about a law."""
    match law:
        case SeparationLaw():
            return LawSheet(
                "ISO/TS 15066:2016, clause 5.5.4, linear form (Marvel and Norcross 2017)",
                Markup("S = {} ({} + {}) + {} {} + B + δ").format(_HUMAN, _T1, _T2, _ROBOT, _T1),
                (
                    *_times(law.t1, law.t2),
                    (Markup("B"), _metres(law.stopping), "distance covered while stopping"),
                    (Markup("δ"), _metres(law.intrusion), "intrusion allowance"),
                    *_SPEEDS,
                ),
            )
        case IntegralLaw():
            stopping = (
                Markup("the way of a speed that falls evenly to 0 within {}").format(_T2)
                if law.stopping is None
                else _metres(law.stopping)
            )
            return LawSheet(
                "ISO/TS 15066:2016, clause 5.5.4.2.3, integral form",
                Markup(
                    "S = ∫<sub>0</sub><sup>{0}+{1}</sup> {2} dt + ∫<sub>0</sub><sup>{0}</sup>"
                    " {3} dt + S<sub>S</sub> + C + Z<sub>D</sub> + Z<sub>R</sub>"
                ).format(_T1, _T2, _HUMAN, _ROBOT),
                (
                    *_times(law.t1, law.t2),
                    (Markup("S<sub>S</sub>"), stopping, "way of the machine while it stops"),
                    (Markup("C"), _metres(law.intrusion), "intrusion distance"),
                    (
                        Markup("Z<sub>D</sub>"),
                        _metres(law.human_uncertainty),
                        "uncertainty of where the person is",
                    ),
                    (
                        Markup("Z<sub>R</sub>"),
                        _metres(law.robot_uncertainty),
                        "uncertainty of where the machine is",
                    ),
                    *_SPEEDS,
                ),
            )
        case ApproachLaw():
            return LawSheet(
                "ISO 13855:2010, clause 5",
                Markup("S = K T + C"),
                (
                    (Markup("K"), f"{law.speed:g} m/s", "speed of approach of a person"),
                    (Markup("T"), f"{law.time:g} s", "from sensing to the end of the motion"),
                    (Markup("C"), _metres(law.intrusion), "intrusion distance"),
                ),
            )
        case FixedDistance():
            return LawSheet(
                "a fixed distance",
                Markup("S = {}").format(_metres(law.metres)),
                (),
            )
        case Scaled():
            inner = law_sheet(law.law)
            cap = "" if law.cap == math.inf else f", of S at most {_metres(law.cap)}"
            return LawSheet(
                inner.name,
                Markup("{} × S{}, with {}").format(f"{law.factor:g}", cap, inner.formula),
                inner.terms,
            )
        case OwnLaw():
            terms = tuple((escape(k), plain_value(v), "") for k, v in law.terms.items())
            return LawSheet(f"own code: {law.name}", Markup("as programmed"), terms)
    name = str(getattr(law, "name", "") or type(law).__qualname__)
    return LawSheet(f"own code: {name}", Markup("as programmed"), ())


def plain_value(value: object) -> str:
    """Return a term of a law of one's own."""
    return f"{value:g}" if isinstance(value, float) else str(value)


_SPEEDS = (
    (_HUMAN, "", "speed of the person at the instant"),
    (_ROBOT, "", "speed of the machine at the instant"),
)


def _times(t1: float, t2: float) -> tuple[tuple[Markup, str, str], ...]:
    return (
        (_T1, f"{t1:g} s", "time to sense and react"),
        (_T2, f"{t2:g} s", "time to stop"),
    )


def _metres(length: float) -> str:
    return f"{length:g} m"


def floor_facts(plan: Floorplan) -> Facts:
    """Return what the floor is and what is on it."""
    west, south, east, north = plan.boundary.bounds
    there = {
        "obstacle": len(plan.obstacles),
        "station": len(plan.stations),
        "door": len(plan.doors),
        "zone": len(plan.zones),
        "AGV lane": len(plan.lanes),
        "gantry": int(plan.gantry is not None),
    }
    rows: list[tuple[str, Cell]] = [
        ("name", plan.title or plan.name),
        ("source", plan.source or NO_SOURCE),
        ("size", f"{east - west:g} m × {north - south:g} m, {plan.boundary.area:,.1f} m² inside"),
        ("on it", ", ".join(counted(n, what) for what, n in there.items() if n) or "nothing"),
        *(("left out or taken for granted", str(notice)) for notice in plan.notices[:MOST_NOTICES]),
    ]
    if (more := len(plan.notices) - MOST_NOTICES) > 0:
        rows.append(("", f"and {more} more notices, as of floorwalker check"))
    return Facts(rows, "The floor")


NO_SOURCE = "no source given"

MOST_NOTICES = 10
"""Notices of a floor that are printed."""


def _rules(zone: Zone) -> Iterator[str]:
    if zone.forbidden:
        yield "forbidden"
    if zone.max_speed is not None:
        yield f"at most {zone.max_speed:g} m/s"
    if zone.one_way is not None:
        yield minus("one way, towards ({:g}, {:g})".format(*zone.one_way))


def zones_table(plan: Floorplan) -> ReportTable:
    """Return the zones of a floor with their rules."""
    rows = [
        (
            zone.name,
            f"{zone.area.area:,.1f}",
            ", ".join(_rules(zone)),
            "everybody" if zone.concerns == ("*",) else ", ".join(zone.concerns),
        )
        for zone in plan.zones
    ]
    heads = ("zone", "area, m²", "rule", "for")
    return ReportTable(heads, rows, "Zones", figures=frozenset({1}))


def machines_table(scene: Scene, models: Mapping[str, MachineModel]) -> ReportTable:
    """Return the machines: sizes, top speeds, and the stops that their limits leave them."""
    rows = []
    for names, shape, stop in _alike(scene, models):
        size = f"{shape.length:g} × {shape.width:g}, from {shape.bottom:g} to {shape.top:g} high"
        stops = "not known" if stop is None else f"{stop[0]:.2f} s, {stop[1]:.2f} m"
        law = _law_key(scene.rules, shape)
        rows.append((listed(names), shape.kind, size, f"{shape.top_speed:.2f}", stops, law))
    words = "Sizes in metres. The stop is the longest and farthest that the limits allow."
    heads = ("machine", "kind", "size", "top speed, m/s", "stop", "law")
    return ReportTable(heads, rows, "Machines", words, frozenset({3}))


def _alike(
    scene: Scene, models: Mapping[str, MachineModel]
) -> Iterable[tuple[list[str], MachineShape, tuple[float, float] | None]]:
    """Yield machines that differ in their names alone, together."""
    groups: dict[str, tuple[list[str], MachineShape, tuple[float, float] | None]] = {}
    for shape in scene.machines:
        model = models.get(shape.name)
        stop = None if model is None else model.longest_stop(scene.floorplan)
        size = (shape.kind, shape.length, shape.width, shape.bottom, shape.top, shape.top_speed)
        key = repr((size, stop, _law_key(scene.rules, shape)))
        groups.setdefault(key, ([], shape, stop))[0].append(shape.name)
    return groups.values()


def _law_key(rules: RuleSet, shape: MachineShape) -> str:
    return rules.law_and_key_of(shape)[0]


def laws_of(rules: RuleSet, machines: Iterable[MachineShape]) -> list[tuple[str, AnyLaw]]:
    """Return the laws that hold for some machines, each with its keys and machines in words."""
    found: list[tuple[AnyLaw, dict[str, list[str]]]] = []
    for machine in machines:
        key, law = rules.law_and_key_of(machine)
        known = next((keys for other, keys in found if other == law), None)
        if known is None:
            found.append((law, known := {}))
        known.setdefault(key, []).append(machine.name)
    return [
        ("; ".join(f"{key}: {listed(names)}" for key, names in keys.items()), law)
        for law, keys in found
    ]


def law_table(laws: Sequence[tuple[str, AnyLaw]]) -> ReportTable:
    """Return laws, each with the machines or trials it holds for, its formula and its terms."""
    rows: list[Sequence[Cell]] = []
    for key, law in laws:
        sheet = law_sheet(law)
        terms = Markup("<br>").join(_term(*term) for term in sheet.terms)
        formula = Markup('<span class="formula">{}</span>').format(sheet.formula)
        rows.append((key, sheet.name, formula, terms))
    return ReportTable(
        ("holds for", "law", "required distance", "terms"), rows, "Required distances"
    )


def _term(symbol: Markup, value: str, meaning: str) -> Markup:
    if not value:
        return Markup("{}: {}").format(symbol, meaning)
    return Markup("{} = {}{}").format(symbol, value, f", {meaning}" if meaning else "")


def rules_facts(rules: RuleSet) -> Facts:
    """Return what follows from a violation, and when people notice a machine."""
    machine = {
        "none": "goes on",
        "stop": "makes a protective stop until there is room again",
        "disable": f"a gantry is disabled for {rules.gantry_disabled:g} s (a penalty)"
        + (f"; no consequence in the {rules.grace:g} s after that" if rules.grace else ""),
    }[rules.machine]
    pause = f"{rules.pause_after_violation:g} s ({rules.pause_after_agv:g} s for an AGV)"
    person = {
        "none": "walks on, and does not know of it",
        "teleport": f"is put into the safe zone and waits there for {pause}",
    }[rules.person]
    notice = rules.notice
    noticed = law_sheet(notice.law)
    again = (
        f"once until the two have parted by {notice.parting:g} m"
        if notice.every is None
        else f"at most every {notice.every:g} s"
    )
    rows: list[tuple[str, Cell]] = [
        ("rule set", f"{rules.name}{f' ({rules.summary})' if rules.summary else ''}"),
        ("a violation", VIOLATION),
        ("the machine", machine),
        ("the person", person),
        ("people notice a robot", Markup("inside {}; {}").format(noticed.formula, again)),
    ]
    if rules.reactions:
        waits = (f"{name} {seconds:g} s" for name, seconds in rules.reactions.items())
        rows.append(("people react to a robot after", ", ".join(waits)))
    if rules.agv_offset:
        point = f"the point {rules.agv_offset:g} m along its lane from its centre"
        rows.append(("distance to an AGV", f"to {point}"))
    if rules.between_people is not None:
        rows.append(("between people", f"recorded below {rules.between_people:g} m"))
    return Facts(rows)


VIOLATION = (
    "begins when a person is nearer to a robot, or to a vehicle that moves, than the law requires;"
    " distances are between the centres on the floor"
)


def resolution() -> Points:
    """Return how exact the figures of a report are."""
    return Points(
        (
            "Motions are formulas of time. The instants at which violations begin and end are"
            " solved for, right to 0.1 µs; none that is longer is missed.",
            "The least margin of a violation is solved for to 1 µm where the law is a formula of"
            f" two speeds, else looked for every {MOMENT:g} s.",
            f"Exposure to zones is summed up in steps of {MOMENT:g} s while somebody moves: a time"
            " is right to that for each time that they come in or go out.",
            f"Maps have cells of {CELL:g} m and the same steps; a spot counts while it is under the"
            " body of a person.",
            "The same trial and seed give the same run, to the byte: every figure can be repeated.",
        ),
        "Resolution",
    )


def counted(count: int, what: str) -> str:
    """Return how many there are of something."""
    if what == "person":
        return "1 person" if count == 1 else f"{count:,} people"
    plural = f"{what[:-1]}ies" if what.endswith("y") and what[-2] not in "aeiou" else f"{what}s"
    return f"{count:,} {what if count == 1 else plural}"


def span(begin: float, end: float) -> str:
    """Return an interval of time as the trial has it."""
    return f"{as_given(begin)} – {'the end' if end == math.inf else as_given(end)}"


def people_tables(scene: Scene, scenario: Scenario | None) -> list[ReportTable]:
    """Return who is on the floor; a recording without its trial knows bodies alone."""
    if scenario is None:
        return [_bodies(scene)]
    return [_people(scenario), *_work(scenario)]


def sources_facts(scenario: Scenario) -> Facts:
    """Return the source of each assumption that needs one."""
    given = {**scenario.sources}
    if scenario.floorplan.source:
        given.setdefault("floorplan", scenario.floorplan.source)
    rows = [(name, given.pop(name, NO_SOURCE)) for name in assumed(scenario)]
    return Facts([*rows, *given.items()], "Sources of the assumptions")


def assumed(scenario: Scenario) -> list[str]:
    """Return the keys of what a trial assumes, and whose source a reader will ask for."""
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


def drawn(value: Drawn | None, otherwise: str = "–") -> str:
    """Return a figure, or the distribution it is drawn from, in words."""
    if value is None:
        return otherwise
    if isinstance(value, Duration):
        return distribution(value)
    if isinstance(value, tuple):
        return f"uniform, {value[0]:g} … {value[1]:g}"
    return plain(value)


def distribution(value: Duration) -> str:
    """Return a distribution in words."""
    figures = [plain(one) for one in value.values]
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


def _bodies(scene: Scene) -> ReportTable:
    groups: dict[tuple[str, ...], list[str]] = {}
    for one in scene.people:
        about = (Path(one.personality).stem, f"{one.radius:g}", f"{one.height:g}")
        groups.setdefault(about, []).append(one.name)
    rows = [(listed(names), *about) for about, names in groups.items()]
    words = (
        "A recording holds neither speeds and distributions nor their sources: a report of the"
        " trial itself has them."
    )
    heads = ("who", "personality", "radius, m", "height, m")
    return ReportTable(heads, rows, "People", words, frozenset({2, 3}))


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


def _people(scenario: Scenario) -> ReportTable:
    groups: dict[tuple[str, ...], list[str]] = {}
    for one in scenario.people:
        about = tuple(_about(one, scenario.floorplan).values())
        groups.setdefault(about, []).append(one.name)
    rows = [(listed(names), *about) for about, names in groups.items()]
    same = [k for k in range(len(_HEADS)) if {row[k] for row in rows} <= {"–"}]
    kept = [k for k in range(len(_HEADS)) if k not in same]
    heads = [*_HEADS.values()]
    words = (
        f"Bodies are discs, {scenario.floorplan.human.height:g} m high. Who has no field of view of"
        " their own notices machines all round; what is drawn is drawn for each person from the"
        " seed."
        if rows
        else "There is nobody on the floor."
    )
    return ReportTable(
        [heads[k] for k in kept], [[row[k] for k in kept] for row in rows], "People", words
    )


def _about(one: PersonEntry, plan: Floorplan) -> Mapping[str, str]:
    human = plan.human
    recorded = one.recorded
    if recorded is not None:
        where = "a motion" if isinstance(recorded, Motion) else recorded.file
        none = ("speed", "acceleration", "sight", "occlusion", "reaction", "lag")
        return {
            "personality": f"recorded: {where}",
            "radius": plain(one.radius or human.radius),
            **dict.fromkeys(none, "–"),
            "start": _start(one.start),
            "work": "–",
        }
    changes = "".join(f", then {Path(c.personality_name).stem}" for c in one.changes)
    return {
        "personality": Path(one.personality_name).stem + changes,
        "radius": plain(one.radius or human.radius),
        "speed": drawn(one.max_speed, plain(human.max_speed)),
        "acceleration": plain(one.max_acceleration or human.max_acceleration),
        "sight": drawn(one.noticing.field_of_view),
        "occlusion": "yes" if one.noticing.occlusion else "–",
        "reaction": drawn(one.noticing.reaction_time),
        "lag": drawn(one.agent_lag),
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


def _work(scenario: Scenario) -> Iterator[ReportTable]:
    alike: dict[tuple[str, str, str, bool], list[WorkTask]] = {}
    for name, held in scenario.work.items():
        for task in held.tasks:
            task_name = task.name or "–"
            key = (name, task_name, distribution(task.duration), task.every is not None)
            alike.setdefault(key, []).append(task)
    rows = [
        (
            name,
            task_name,
            listed([*dict.fromkeys(task.at for task in tasks)]),
            length,
            _often(tasks, scenario.work[name].repeat),
            _range([task.priority for task in tasks]),
        )
        for (name, task_name, length, _), tasks in alike.items()
    ]
    if rows:
        heads = ("list", "task", "stations", "length, s", "when", "priority")
        yield ReportTable(heads, rows, "Work", figures=frozenset({5}))


def _often(tasks: Sequence[WorkTask], repeat: bool) -> str:
    """Return when some tasks are there, and when they come again."""
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
    """Return the least and the most of some figures."""
    low, high = min(figures), max(figures)
    return plain(low) if low == high else f"{plain(low)} … {plain(high)}"
