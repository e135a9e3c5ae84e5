"""The safety report of a single run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from ...core.scenario import Scenario
from ...record.incidents import (
    Incident,
    incidents,
    time_on_floor,
    time_too_close,
    worst_first,
)
from ...record.outcome import Outcome
from ...record.risk import RISKS, risk
from ...record.summary import figures_in_words
from .assumptions import counted, law_table, laws_of, resolution, rules_facts
from .findings import MOST_INCIDENTS, exposure_table, incidents_table, together
from .limits import limits
from .parts import Facts, Part, Points, Section, Table, clock, metres
from .pictures import risk_pictures, run_pictures
from .provenance import inputs, software
from .setting import assumptions

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
        parts.append(Table(("", "expectation"), rows, "Expectations"))
    return parts


def _summary(run: Outcome) -> Iterator[Table]:
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
    yield Table(("figure", "value"), others, words=ONE_RUN)
    labels = [*dict.fromkeys(label for figures in of_people.values() for label in figures)]
    if labels:
        rows = [
            (name, *(figures.get(label, "–") for label in labels))
            for name, figures in of_people.items()
        ]
        yield Table(("who", *labels), rows, "People")


def _maps(run: Outcome, count: int) -> list[Part]:
    if not (run.scene.people and run.scene.machines):
        return [Points(("There is no risk without both people and machines.",))]
    maps = {of: risk(run, of) for of in RISKS}
    return risk_pictures(run.floorplan, run.scene.machines, maps, count)


def _exposure(run: Outcome) -> Table:
    zones = run.summary.get("zones", {})
    return exposure_table(run.floorplan, zones, time_on_floor(run), time_too_close(run))


def _violations(worst: Sequence[Incident]) -> list[Part]:
    listed = incidents_table(worst[:MOST_INCIDENTS], len(worst))
    return [listed, together(worst)] if worst else [listed]


def _seed(run: Outcome) -> Facts:
    return Facts([("seed", str(run.scene.seed)), ("trial", run.scene.trial)], "The run")
