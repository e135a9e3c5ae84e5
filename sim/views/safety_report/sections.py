"""Sections of a safety report: provenance, limits, setting, and those of a single run."""

from __future__ import annotations

import platform
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version

from navigation.kernels import COMPILED

from ...core.entries import COMMANDS
from ...core.recorder import Scene
from ...core.rules import RuleSet
from ...core.scenario import Scenario
from ...machines.kinds import in_words, models_of, on_floor, short_laws
from ...record.incidents import (
    RISKS,
    Incident,
    incidents,
    risk,
    time_on_floor,
    time_too_close,
    worst_first,
)
from ...record.outcome import Outcome
from ...record.summary import figures_in_words
from .assumptions import (
    NO_SOURCE,
    assumed,
    counted,
    floor_facts,
    law_table,
    laws_of,
    machines_table,
    people_tables,
    resolution,
    rules_facts,
    sources_facts,
    span,
    zones_table,
)
from .findings import (
    MOST_INCIDENTS,
    exposure_table,
    floor_picture,
    incidents_table,
    risk_pictures,
    run_pictures,
    together,
)
from .page import Facts, Part, Points, ReportTable, Section, clock, metres

LIBRARIES = ("numpy", "shapely", "ompl", "python-fcl", "ruckig", "simpy")
"""Packages that figures may depend on in their last digits."""


def software() -> Facts:
    """Return what computed the figures."""
    kernels = "compiled" if COMPILED else "not compiled"
    return Facts(
        (
            ("Floorwalker", f"{_version('floorwalker')}, kernels {kernels}"),
            ("Python", f"{platform.python_version()} ({platform.python_implementation()})"),
            ("platform", f"{platform.system()} {platform.machine()}"),
            ("libraries", ", ".join(f"{name} {_version(name)}" for name in LIBRARIES)),
        ),
        "Software",
    )


def inputs(digests: Mapping[str, str]) -> ReportTable:
    """Return the digests of what was read."""
    words = "The first 64 bits of SHA-256. Another digest is another input."
    return ReportTable(("what", "digest"), [*digests.items()], "Inputs", words)


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # built into the system
        return "unknown"


ALWAYS = (
    "This is no risk assessment (ISO 12100) and no certificate. It says what follows from the"
    " assumptions above, and nothing about how well they fit the plant.",
    "People do what their personalities say: programs, not measured behaviour. Somebody who"
    " stumbles, runs, climbs, kneels or reaches out is not in them.",
    "Bodies are discs on the floor, and distances are between centres: arms, loads and tools stick"
    " out of both. How near surfaces come is not in the figures.",
    "Machines move as their limits allow and as their controllers say: no drift, no failure of a"
    " brake, no loss of a load, no delay of a network, unless a trial has it.",
    "Sensors see everybody at all times, unless a trial has blackouts. What a protective device"
    " would have seen is not simulated.",
    "There is no contact: severity is a speed, not a force or a pressure, and ends where the"
    " distance is kept again.",
    "Only distances between people and machines are judged. Crushing, shearing, falling objects,"
    " electricity, noise and the like are not.",
)


def limits(
    rules: Iterable[RuleSet], scenarios: Iterable[Scenario], further: Iterable[str] = ()
) -> Points:
    """Return what can't be concluded from a report under these rules, of these trials."""
    found = [*further, *dict.fromkeys(_of_rules(rules)), *dict.fromkeys(_of_trials(scenarios))]
    return Points((*found, *ALWAYS))


def _of_rules(rules: Iterable[RuleSet]) -> Iterator[str]:
    for one in rules:
        if one.person == "teleport":
            yield (
                f"Under the rules {one.name} a person who was too close is put into the safe zone:"
                " a violation ends there, and how it would have gone on is not known."
            )
        if one.machine == "none":
            yield (
                f"Under the rules {one.name} a violation changes nothing: machines do not stop for"
                " people, unless their controllers do."
            )


def _of_trials(scenarios: Iterable[Scenario]) -> Iterator[str]:
    for one in scenarios:
        if short := short_laws(one):
            yield (
                "A law counts on shorter stops than machines may take: a person who keeps the"
                f" distance can still be reached. {in_words(short)}."
            )
        known = {*one.sources, *(["floorplan"] if one.floorplan.source else [])}
        missing = [name for name in assumed(one) if name not in known]
        if missing:
            yield f"There is {NO_SOURCE} for {', '.join(missing)} in the trial {one.name}."
        if any(person.recorded is not None for person in one.people):
            yield (
                "Those who were recorded walk as they were measured, whatever the machines do: they"
                " react to nothing that was not there when they were measured."
            )


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
    return [ReportTable(("what", "how", "when"), rows, "What changes meanwhile")] if rows else []


ASSUMED_FIGURES = ("personality",)
"""Figures of people that stand among the assumptions."""

ONE_RUN = (
    "This is a single run: one draw of what may happen. It has no intervals of confidence; a study"
    " of many runs has."
)


def run_sections(
    run: Outcome,
    scenario: Scenario | None,
    *,
    digests: Mapping[str, str],
    verdicts: Sequence[tuple[str, bool]] = (),
) -> list[Section]:
    """Return the report of a run; `scenario` is its trial, None where only a recording is left.

    `digests` are those of what was read, `verdicts` the expectations and whether they were met.
    """
    found = incidents(run)
    worst = worst_first(found)
    rules = run.scene.rules
    return [
        Section("In short", [_in_short(run, found, verdicts)]),
        Section("Assumptions", assumptions(run.scene, scenario)),
        Section("Rules", [rules_facts(rules), law_table(laws_of(rules, run.scene.machines))]),
        Section("Figures", _figures(run, verdicts)),
        Section("Risk over the floor", _maps(run, len(found))),
        Section("Exposure", [_exposure(run)]),
        Section("Violations", _violations(worst)),
        Section("Pictures of the run", run_pictures(run, worst)),
        Section("How it was computed", [resolution(), _seed(run), software(), inputs(digests)]),
        Section(
            "What this report does not say",
            [limits([rules], [scenario] if scenario else [], [ONE_RUN])],
        ),
    ]


def _in_short(
    run: Outcome, found: Sequence[Incident], verdicts: Sequence[tuple[str, bool]]
) -> Facts:
    scene = run.scene
    near, there = time_too_close(run), time_on_floor(run)
    rows = [
        ("trial", f"{scene.trial} on {scene.floorplan.title or scene.floorplan.name}"),
        ("simulated", f"{clock(run.duration)} (h:mm:ss), seed {scene.seed}"),
        (
            "on the floor",
            f"{counted(len(scene.people), 'person')}, {counted(len(scene.machines), 'machine')};"
            f" {there / 3600:.2f} hours of people's time",
        ),
        ("rules", scene.rules.name),
        ("violations", f"{len(found):,}" if found else "none"),
    ]
    if found:
        least = min(one.margin for one in found)
        rows += [
            ("nearer than required", f"{near:.2f} s in all"),
            ("least margin", f"{metres(least)} m"),
            ("highest relative speed", f"{max(one.severity for one in found):.2f} m/s"),
        ]
    if verdicts:
        met = sum(one for _, one in verdicts)
        rows.append(("expectations", f"{met} of {len(verdicts)} met"))
    if not run.summary:
        rows.append(("interrupted", "the run was broken off; all is as far as it was recorded"))
    return Facts(rows)


def _figures(run: Outcome, verdicts: Sequence[tuple[str, bool]]) -> list[Part]:
    parts: list[Part] = [*_summary(run)] if run.summary else []
    if not parts:
        parts.append(Points(("The run was broken off: it has no summary.",)))
    if verdicts:
        rows = [("met" if met else "not met", words) for words, met in verdicts]
        parts.append(ReportTable(("", "expectation"), rows, "Expectations"))
    return parts


def _summary(run: Outcome) -> Iterator[ReportTable]:
    """Yield the figures of a run, and those of its people in a line for each."""
    people = [person.name for person in run.scene.people]
    of_people: dict[str, dict[str, str]] = {name: {} for name in people}
    others = []
    for line, amount in figures_in_words(run.summary, in_short=False):
        name, _, label = line.partition(": ")
        if name not in of_people:
            others.append((line, amount))
        elif label not in ASSUMED_FIGURES:
            of_people[name][label] = amount
    yield ReportTable(("figure", "value"), others, words=ONE_RUN)
    labels = [*dict.fromkeys(label for figures in of_people.values() for label in figures)]
    if labels:
        rows = [
            (name, *(figures.get(label, "–") for label in labels))
            for name, figures in of_people.items()
        ]
        yield ReportTable(("who", *labels), rows, "People")


def _maps(run: Outcome, count: int) -> list[Part]:
    if not (run.scene.people and run.scene.machines):
        return [Points(("There is no risk without both people and machines.",))]
    maps = {of: risk(run, of) for of in RISKS}
    return risk_pictures(run.floorplan, run.scene.machines, maps, count)


def _exposure(run: Outcome) -> ReportTable:
    zones = run.summary.get("zones", {})
    return exposure_table(run.floorplan, zones, time_on_floor(run), time_too_close(run))


def _violations(worst: Sequence[Incident]) -> list[Part]:
    listed = incidents_table(worst[:MOST_INCIDENTS], len(worst))
    return [listed, together(worst)] if worst else [listed]


def _seed(run: Outcome) -> Facts:
    return Facts([("seed", str(run.scene.seed)), ("trial", run.scene.trial)], "The run")
