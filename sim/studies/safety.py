"""Safety reports of runs and studies, as HTML or PDF."""

from __future__ import annotations

import hashlib
import json
import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from floorplan.files.values import require
from navigation.benchmark.reports import share
from navigation.separation import AnyLaw

from ..core.output import writing
from ..core.recorder import Scene
from ..record.incidents import (
    RISKS,
    Incident,
    Risk,
    incidents,
    risk,
    risk_of_all,
    time_on_floor,
    time_too_close,
    worst_first,
)
from ..record.sampling import CellArray
from ..runs.run import Recorded, Run
from ..simulation import Simulation, run
from ..views.safety_report.assumptions import counted, law_table, laws_of, resolution, rules_facts
from ..views.safety_report.findings import (
    exposure_table,
    incidents_table,
    risk_pictures,
    run_pictures,
)
from ..views.safety_report.page import (
    Facts,
    Part,
    Points,
    ReportTable,
    Section,
    clock,
    metres,
    require_writable,
    write_safety_page,
)
from ..views.safety_report.sections import assumptions, inputs, limits, run_sections, software
from .comparison import Comparison, Measure, StudyResults, spread
from .design import Study
from .folder import RESULTS, identity
from .report import figures, sensitivity
from .running import of_rows

VIOLATIONS = Measure("Violations", "safety.violations", "", "with any machine", chief=True)

TOO_NEAR = Measure("Nearer than required", "safety.near", "s", "all people together", chief=True)

MARGIN = Measure("Least margin", "safety.margin", "m", "to a required distance", chief=True)

KEPT = 40
"""The worst violations of a row that are kept."""


@dataclass(frozen=True, eq=False)
class RowFindings:
    """Findings of one row: how many violations, the worst of them, times in seconds, maps.

    `margin` is the least margin to a required distance (metres), NaN where nothing was required.
    """

    count: int
    worst: list[Incident]
    on_floor: float
    near: float
    margin: float
    maps: dict[Risk, CellArray]


@dataclass(eq=False)
class Findings:
    """Findings of all rows that did not fail.

    `maps` are those of all rows of a trial together, by its number. `worst` has the worst
    violations with the numbers of their rows.
    """

    rows: dict[int, RowFindings] = field(default_factory=dict)
    worst: list[tuple[int, Incident]] = field(default_factory=list)
    maps: dict[int, dict[Risk, CellArray]] = field(default_factory=dict)

    def add(self, row: int, trial: int, found: RowFindings) -> None:
        """Take in what was found in the row and the trial of these numbers."""
        self.worst += [(row, one) for one in found.worst]
        self.worst.sort(key=lambda one: (one[1].margin, one[0], one[1].begin))
        del self.worst[KEPT:]
        mine = self.maps.setdefault(trial, {})
        for of, cells in found.maps.items():
            mine[of] = risk_of_all([mine[of], cells], of) if of in mine else cells
        # The maps of single rows are not needed any more, and are large.
        self.rows[row] = replace(found, worst=[], maps={})


def findings(
    study: Study,
    failed: set[int],
    *,
    jobs: int | None = None,
    progress: Callable[[int], None] = lambda _: None,
) -> Findings:
    """Run every row that did not fail once more, and return what is found in all of them.

    `progress` is given the number of rows that are done.
    """
    together = Findings()
    each = len(study.combinations) // len(study.trials)
    rows = (row for row in study.rows() if row.number not in failed)
    for done, (row, found) in enumerate(of_rows(rows, row_findings, jobs=jobs), 1):
        together.add(row.number, row.number % len(study.combinations) // each, found)
        progress(done)
    return together


def row_findings(finished: Run) -> RowFindings:
    """Return what is found in the run of a row."""
    found = worst_first(incidents(finished))
    both = finished.scene.people and finished.scene.machines
    maps = {of: risk(finished, of) for of in RISKS} if both else {}
    margins = [one.margin for one in found[:1]]
    if both:
        margins.append(float(maps["margin"].min()))
    return RowFindings(
        count=len(found),
        worst=found[:KEPT],
        on_floor=time_on_floor(finished),
        near=time_too_close(finished),
        margin=min(filter(math.isfinite, margins), default=math.nan),
        maps=maps,
    )


def with_findings(compared: Comparison, found: Findings) -> Comparison:
    """Return a comparison that has the findings of the rows among its measures, before others."""
    count = sum(len(group.rows) for group in compared.groups)
    nothing = RowFindings(0, [], math.nan, math.nan, math.nan, {})
    rows = [found.rows.get(k, nothing) for k in range(count)]
    known = np.array([float(k in found.rows) for k in range(count)])
    figures = {
        VIOLATIONS: np.where(known > 0, [float(one.count) for one in rows], math.nan),
        TOO_NEAR: np.array([one.near for one in rows]),
        MARGIN: np.array([one.margin for one in rows]),
    }
    spreads = {
        measure: tuple(spread(values[group.rows]) for group in compared.groups)
        for measure, values in figures.items()
    }
    return replace(compared, spreads=spreads | compared.spreads, values=figures | compared.values)


def study_sections(results: StudyResults, found: Findings) -> list[Section]:
    """Return the sections of the report on `results`, with what was `found` in their runs."""
    study, compared = results.study, with_findings(results.comparison, found)
    scenes = [Simulation(trial).scene for trial in study.trials]
    rules = [combination.trial.rules for combination in study.combinations]
    once = "Intervals say how much means differ between runs like these, by chance; they say"
    once += " nothing about how far the model is from the plant."
    return [
        Section("In short", [_in_short(results, found)]),
        Section("What was varied", [_varied(study)]),
        *_assumptions(study, scenes),
        Section("Rules", [*_rules(study), law_table(_laws(study, scenes))]),
        Section("Figures", figures(compared), INTERVALS),
        Section("Sensitivity", list(sensitivity(compared))),
        Section("Runs with violations", [_shares(compared, found)]),
        Section("Risk over the floor", list(_maps(scenes, found))),
        Section("Exposure", list(_exposure(results, found))),
        Section("Violations", [_violations(found)]),
        Section("The run with the worst violation", list(_worst_run(study, found))),
        Section(
            "How it was computed",
            [resolution(), _repeating(results), software(), inputs(identity(study))],
        ),
        Section("What this report does not say", [limits(rules, study.trials, [once])]),
    ]


INTERVALS = (
    "Means over runs, with the interval that holds the true mean with 95 % confidence (percentile"
    " bootstrap over runs, Efron 1979); with fewer than about ten runs it is too narrow."
)


def _in_short(results: StudyResults, found: Findings) -> Facts:
    study = results.study
    hours = sum(float(t) for t in results.columns.get("duration", ()) if t is not None) / 3600
    there = math.fsum(one.on_floor for one in found.rows.values()) / 3600
    near = math.fsum(one.near for one in found.rows.values())
    count = sum(one.count for one in found.rows.values())
    with_some = [float(one.count > 0) for one in found.rows.values()]
    rows = [
        ("trials", ", ".join(trial.name for trial in study.trials)),
        (
            "runs",
            f"{counted(len(study.combinations), 'combination')} × {study.repeat},"
            f" {len(results):,} in all" + _failed(results),
        ),
        ("simulated", f"{hours:,.2f} hours, {there:,.2f} hours of people's time"),
        ("violations", f"{count:,}" if count else "none"),
        ("runs with a violation", _interval(with_some)),
    ]
    if found.worst:
        rows += [
            ("nearer than required", f"{near:,.2f} s in all"),
            ("least margin", f"{metres(found.worst[0][1].margin)} m, in row {found.worst[0][0]}"),
        ]
    unmet = [float(n) for n in results.columns.get("unmet", ()) if n is not None]
    if any(trial.expect for trial in study.trials):
        missed = sum(n > 0 for n in unmet)
        rows.append(("expectations", f"met in {len(unmet) - missed:,} of {len(unmet):,} runs"))
    return Facts(rows)


def _failed(results: StudyResults) -> str:
    return f"; {len(results.failed):,} failed and are in no figure" if results.failed else ""


def _interval(shares: Sequence[float]) -> str:
    """Return a share of runs with its interval, in words."""
    if not shares:
        return "–"
    found = share(shares)
    low, high = (f"{100 * end:.1f}" for end in (found.low, found.high))
    return f"{sum(shares):.0f} of {len(shares):,}: {100 * found.value:.1f} % ({low} … {high} %)"


def _varied(study: Study) -> Facts:
    rows = [(what.name, ", ".join(map(str, values))) for what, values in study.grid.items()]
    rows += [(what.name, f"drawn: {drawn}") for what, drawn in study.random.items()]
    rows.append(("each combination", f"{study.repeat:,} times, seed {study.seed}"))
    words = "In the n-th repetition all combinations meet the same draws."
    return Facts(rows, "", words)


def _assumptions(study: Study, scenes: Sequence[Scene]) -> Iterator[Section]:
    words = "As the trial has it, where it was not varied." if study.grid or study.random else ""
    for trial, scene in zip(study.trials, scenes, strict=True):
        title = "Assumptions" if len(scenes) == 1 else f"Assumptions of {trial.name}"
        yield Section(title, assumptions(scene, trial), words)


def _rules(study: Study) -> Iterator[Part]:
    """Yield the rule sets, those of the same words once."""
    facts = [rules_facts(combination.trial.rules) for combination in study.combinations]
    yield from {repr(one.rows): one for one in facts}.values()


def _laws(study: Study, scenes: Sequence[Scene]) -> list[tuple[str, AnyLaw]]:
    """Return each law once, with what it holds for and in how many combinations."""
    held: Counter[tuple[str, AnyLaw]] = Counter()
    each = len(study.combinations) // len(study.trials)
    for k, combination in enumerate(study.combinations):
        rules, machines = combination.trial.rules, scenes[k // each].machines
        for key in dict.fromkeys(rules.law_and_key_of(machine)[0] for machine in machines):
            mine = [one for one in machines if rules.law_and_key_of(one)[0] == key]
            held.update(laws_of(rules, mine))
    every = len(study.combinations)
    return [
        (whom if count == every else f"{whom}, in {count} of {every} combinations", law)
        for (whom, law), count in held.items()
    ]


def _shares(compared: Comparison, found: Findings) -> ReportTable:
    """Return for each combination how many of its runs had a violation."""
    rows = []
    for group in compared.groups:
        mine = [found.rows[row] for row in group.rows.tolist() if row in found.rows]
        there = math.fsum(one.on_floor for one in mine) / 3600
        count = sum(one.count for one in mine)
        rows.append(
            (
                *(group.values or ("all rows",)),
                _interval([float(one.count > 0) for one in mine]),
                f"{count:,}",
                f"{count / there:,.2f}" if there else "–",
            )
        )
    words = (
        "The share of runs with at least one violation, with Wilson's interval of 95 %: where there"
        " was none it says how many there may be all the same."
    )
    several = compared.factors or ("",)
    heads = (*several, "runs with a violation", "violations", "per hour of people's time")
    n = len(heads)
    return ReportTable(heads, rows, "", words, frozenset({n - 2, n - 1}))


def _maps(scenes: Sequence[Scene], found: Findings) -> Iterator[Part]:
    count = sum(one.count for one in found.rows.values())
    if not any(found.maps.values()):
        yield Points(("There is no risk without both people and machines.",))
    for number, scene in enumerate(scenes):
        if maps := found.maps.get(number):
            if len(scenes) > 1:
                yield Points((f"All runs of {scene.trial} together:",))
            yield from risk_pictures(scene.floorplan, scene.machines, maps, count, scene.trial)


def _exposure(results: StudyResults, found: Findings) -> Iterator[ReportTable]:
    """Yield the means of a run's exposure to each zone, for each trial."""
    columns = results.columns
    trials = columns.get("trial", [])
    for trial in results.study.trials:
        lines = [k for k, name in enumerate(trials) if name == trial.name]
        mine = [found.rows[k] for k in lines if k in found.rows]
        zones: dict[str, Mapping[str, float]] = {}
        for zone in trial.floorplan.zones:
            figures = {
                key: _mean_of(columns.get(f"zones.{zone.name}.{key}", ()), lines)
                for key in ("time_occupied", "entries", "time_too_close")
            }
            zones[zone.name] = figures
        n = max(1, len(mine))
        there, near = (sum(getattr(one, key) for one in mine) / n for key in ("on_floor", "near"))
        table = exposure_table(trial.floorplan, zones, there, near)
        several = len(results.study.trials) > 1
        title = f"A run of {trial.name}, on average" if several else "A run, on average"
        yield replace(table, title=title)


def _mean_of(column: Sequence[object], lines: Sequence[int]) -> float:
    values = [column[k] for k in lines if k < len(column)]
    known = [float(v) for v in values if isinstance(v, int | float)]
    return math.fsum(known) / len(known) if known else 0.0


def _violations(found: Findings) -> ReportTable:
    rows = [number for number, _ in found.worst]
    count = sum(one.count for one in found.rows.values())
    return incidents_table([one for _, one in found.worst], count, rows)


def _worst_run(study: Study, found: Findings) -> Iterator[Part]:
    if not found.worst:
        yield Points(("There was no violation.",))
        return
    number = found.worst[0][0]
    row = study.row(number)
    values = ", ".join(f"{name} {_in_words(value)}" for name, value in row.parameters.items())
    yield Facts(
        [
            ("row", str(number)),
            ("with", values),
            ("its trial", f"floorwalker study STUDY.yaml --row {number} writes it"),
        ]
    )
    mine = [one for n, one in found.worst if n == number]
    yield from run_pictures(run(row.trial), mine, "worst")


def _in_words(value: object) -> str:
    """Return a parameter of a row."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _repeating(results: StudyResults) -> Facts:
    study, table = results.study, (results.folder / RESULTS).read_bytes()
    return Facts(
        [
            ("rows", f"{len(results):,}, each with a seed that follows from the study's"),
            ("the study's seed", str(study.seed)),
            (f"digest of {RESULTS}", hashlib.sha256(table).hexdigest()[:16]),
        ],
        "The study",
    )


Progress = Callable[[int], None]


def safety_report(
    source: Recorded | StudyResults,
    path: str | Path,
    *,
    jobs: int | None = None,
    progress: Progress = lambda _: None,
) -> None:
    """Write a report that can be handed on: assumptions, rules, figures, violations, limits.

    `source` is a run, or the results of a study; then all its rows are run once more, on `jobs`
    processes (all cores by default), for the maps of risk and the violations one by one, and
    `progress` is given how many are done. `path` ends in .html or .pdf, which Chromium or Chrome
    prints. `ValueError` for another ending, `OutputError` where it can't be written.
    """
    path = Path(path)
    require_writable(path)
    if isinstance(source, StudyResults):
        title, count = source.study.name, counted(len(source), "run")
        subtitle = f"A study of {count}, simulated by Floorwalker"
        found = findings(source.study, {*source.failed}, jobs=jobs, progress=progress)
        sections = study_sections(source, found)
    else:
        require(source, Recorded, "sim.load_run")
        title = source.scene.trial
        subtitle = f"A run of {clock(source.duration)} (h:mm:ss), simulated by Floorwalker"
        sections = _of_run(source)
    with writing(path):
        write_safety_page(path, title=title, subtitle=subtitle, sections=sections)


def _of_run(source: Recorded) -> list[Section]:
    digests = {"what happened": _digest(source)}
    if not isinstance(source, Run):
        return run_sections(source, None, digests=digests)
    trial = source.trial
    try:
        known = identity(Study(trial.name, (trial,)))
    except ValueError:  # put together in Python, from what came from no file
        known = {}
    digests = {what: known[what] for what in known if what != "the study"} | digests
    verdicts = [(f"{one.expected}; {one.found}", one.met) for one in source.verdicts]
    return run_sections(source, trial, digests=digests, verdicts=verdicts)


def _digest(source: Recorded) -> str:
    """Return a digest of the events and motions of a run."""
    digest = hashlib.sha256(json.dumps(source.events, default=str).encode())
    for name, motion in source.motions.items():
        digest.update(f"{name} {[tuple(piece) for piece in motion.pieces]!r}".encode())
    return digest.hexdigest()[:16]
