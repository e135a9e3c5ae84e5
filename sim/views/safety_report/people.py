"""Assumptions about people: who they are, how they walk and notice, and what they have to do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from floorplan import Floorplan
from navigation import Motion

from ...core.noticing import Drawn
from ...core.scenario import ASSUMED, PersonEntry, Scenario
from ...core.scene import Scene
from ...core.start import Start
from ...core.work import Duration, WorkTask, as_given
from .assumptions import NO_SOURCE, span
from .parts import Facts, Table, listed, plain


def people_tables(scene: Scene, scenario: Scenario | None) -> list[Table]:
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


def _bodies(scene: Scene) -> Table:
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
    return Table(heads, rows, "People", words, frozenset({2, 3}))


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


def _people(scenario: Scenario) -> Table:
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
    return Table(
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


def _work(scenario: Scenario) -> Iterator[Table]:
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
        yield Table(heads, rows, "Work", figures=frozenset({5}))


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
