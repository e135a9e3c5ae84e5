"""The setting of a run in print: floor, machines, people, and what changes meanwhile."""

from __future__ import annotations

from ...core.commands import COMMANDS
from ...core.scenario import Scenario
from ...core.scene import Scene
from ...machines.kinds import models_of, on_floor
from .assumptions import floor_facts, machines_table, span, zones_table
from .parts import Part, Table
from .people import people_tables, sources_facts
from .pictures import floor_picture


def assumptions(scene: Scene, scenario: Scenario | None) -> list[Part]:
    """Return what was assumed of the floor, the machines and the people."""
    plan = scene.floorplan
    models = on_floor(Scenario(plan)) if scenario is None else models_of(scenario)
    parts: list[Part] = [floor_facts(plan), *floor_picture(plan)]
    if plan.zones:
        parts.append(zones_table(plan))
    parts += [machines_table(scene, models), *people_tables(scene, scenario)]
    if scenario is not None:
        parts += [*_changes(scenario), sources_facts(scenario)]
    return parts


def _changes(scenario: Scenario) -> list[Part]:
    """Return what changes on the floor in the course of a trial."""
    rows: list[tuple[str, str, str]] = []
    for name, times in scenario.doors.items():
        how = "open" if times.closed is None else "closed"
        rows += [(name, how, span(*interval)) for interval in times.intervals]
    for one in scenario.obstacles:
        rows += [(one.obstacle.name, "is there", span(*interval)) for interval in one.there]
    for each in scenario.every_blackout:
        begins = f"{each.start.time:g} s" if each.start.time is not None else "an event"
        rows.append((each.machine, f"sees nobody for {each.seconds:g} s", f"from {begins} on"))
    for command in scenario.commands:
        wanted = ((key, getattr(command, key)) for key in COMMANDS)
        key, given = next((key, one) for key, one in wanted if one is not None)
        rows.append((str(getattr(given, "name", given)), f"command: {key}", f"{command.time:g} s"))
    return [Table(("what", "how", "when"), rows, "What changes meanwhile")] if rows else []
