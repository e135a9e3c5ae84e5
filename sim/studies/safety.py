"""Safety reports of runs and studies, as HTML or PDF."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import field, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from floorplan import UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.values import require
from navigation.benchmark import share

from ..core.entries import UNSIGNED, SignOff
from ..core.recorder import Scene
from ..core.wording import clock, counted, figure, percent, significant
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
from ..record.output import writing
from ..record.sampling import CellArray
from ..record.stops import MachineTimes, machine_times, times_of_all
from ..record.warm_up import after_warm_up, zones_of
from ..runs.run import Recorded, Run
from ..simulation import Simulation, run
from ..trials.timeline import Verdict
from ..trials.trial import Trial
from ..views.safety_findings import SIGNED_BY, sign_off_rows, stops_in_tables, without_a_job
from ..views.safety_page import (
    Picture,
    exposure,
    require_writable,
    risk_pictures,
    run_pictures,
    write_safety_page,
)
from ..views.safety_run_report import LawInUse, about, laws_of, run_report, software
from .comparison import Comparison, Measure, StudyResults, Trend, sensitivities, spread
from .design import Study
from .identity import digest, identity, parts
from .report import measures_shown, sensitivity_chart
from .running import of_rows
from .table import RESULTS

VIOLATIONS = Measure("Violations", "safety.violations", "", "with any machine", chief=True)

TOO_NEAR = Measure("Nearer than required", "safety.near", "s", "all people together", chief=True)

MARGIN = Measure("Least margin", "safety.margin", "m", "to a required distance", chief=True)

KEPT = 40
"""Number of worst violations that are kept of a row."""


@dataclass(frozen=True, eq=False)
class RowFindings:
    """Findings of one row: number of violations, the worst ones, durations (s), maps.

    `margin` is the least margin to a required distance (m), NaN if none was required. `times` are
    durations of machine states. `zones` is the exposure of people in each zone.
    """

    count: int
    worst: list[Incident]
    on_floor: float
    near: float
    margin: float
    maps: dict[Risk, CellArray]
    times: Sequence[MachineTimes] = ()
    zones: dict[str, dict[str, float]] = field(default_factory=dict)


@dataclass(eq=False)
class Findings:
    """Findings of all rows that did not fail.

    `maps` joins the rows of each trial, by the trial's number. `worst` contains the worst
    violations with the numbers of their rows. `warm_up` is the end of the warm-up (s), or None for
    that of each trial.
    """

    rows: dict[int, RowFindings] = field(default_factory=dict)
    worst: list[tuple[int, Incident]] = field(default_factory=list)
    maps: dict[int, dict[Risk, CellArray]] = field(default_factory=dict)
    warm_up: float | None = None

    def warm_up_of(self, trial: Trial) -> float:
        """Return the end (s) of the omitted warm-up of a trial's runs."""
        return trial.warm_up if self.warm_up is None else self.warm_up

    def add(self, row: int, trial: int, findings: RowFindings) -> None:
        """Add the findings of a row of the trial with this number."""
        self.worst += [(row, one) for one in findings.worst]
        self.worst.sort(key=lambda one: (one[1].margin, one[0], one[1].begin))
        del self.worst[KEPT:]
        mine = self.maps.setdefault(trial, {})
        for of, cells in findings.maps.items():
            mine[of] = risk_of_all([mine[of], cells], of) if of in mine else cells
        # Maps are large, and those of single rows are no longer needed.
        self.rows[row] = replace(findings, worst=[], maps={})


def findings(
    study: Study,
    failed: set[int],
    count: int | None = None,
    *,
    jobs: int | None = None,
    progress: Callable[[int], None] = lambda _: None,
    warm_up: float | None = None,
) -> Findings:
    """Run every row that did not fail again, and return the findings.

    `count` is the number of rows if not all were run. `progress` is called with the number of
    finished rows. The time before `warm_up` (s), or before the trial's own warm-up, is omitted.
    """
    together = Findings(warm_up=warm_up)
    each = len(study.combinations) // len(study.trials)
    finding = partial(row_findings, warm_up=warm_up)
    rows = (row for row in itertools.islice(study.rows(), count) if row.number not in failed)
    for done, (row, found) in enumerate(of_rows(rows, finding, jobs=jobs), 1):
        together.add(row.number, row.number % len(study.combinations) // each, found)
        progress(done)
    return together


def row_findings(whole: Run, warm_up: float | None = None) -> RowFindings:
    """Return the findings of the run of a row after the warm-up."""
    finished = after_warm_up(whole, whole.trial.warm_up if warm_up is None else warm_up)
    violations = worst_first(incidents(finished))
    both = finished.scene.people and finished.scene.machines
    maps = {of: risk(finished, of) for of in RISKS} if both else {}
    margins = [one.margin for one in violations[:1]]
    if both:
        margins.append(float(maps["margin"].min()))
    return RowFindings(
        count=len(violations),
        worst=violations[:KEPT],
        on_floor=time_on_floor(finished),
        near=time_too_close(finished),
        margin=min(filter(math.isfinite, margins), default=math.nan),
        maps=maps,
        times=machine_times(finished),
        zones=zones_of(finished),
    )


def with_findings(compared: Comparison, findings: Findings) -> Comparison:
    """Return a comparison whose first measures are the findings of the rows."""
    count = sum(len(group.rows) * group.repeats for group in compared.groups)
    nothing = RowFindings(0, [], math.nan, math.nan, math.nan, {})
    rows = [findings.rows.get(k, nothing) for k in range(count)]
    is_known = np.array([float(k in findings.rows) for k in range(count)])
    figures = {
        VIOLATIONS: np.where(is_known > 0, [float(one.count) for one in rows], math.nan),
        TOO_NEAR: np.array([one.near for one in rows]),
        MARGIN: np.array([one.margin for one in rows]),
    }
    spreads = {
        measure: tuple(spread(values[group.rows]) for group in compared.groups)
        for measure, values in figures.items()
    }
    return replace(compared, spreads=spreads | compared.spreads, values=figures | compared.values)


def study_report(results: StudyResults, findings: Findings) -> dict[str, Any]:
    """Return the values of `safety_study.html` for `results` and their `findings` findings."""
    study, compared = results.study, with_findings(results.comparison, findings)
    scenes = [Simulation(trial).scene for trial in study.trials]
    rows = findings.rows.values()
    count = sum(one.count for one in rows)
    unmet = [float(n) for n in results.columns.get("unmet", ()) if n is not None]
    trends = [*sensitivities(compared)]
    drawn = (
        (measure, sensitivity_chart(compared, measure, findings)) for measure, findings in trends
    )
    return {
        "study": study,
        "run_count": len(results),
        "failed": len(results.failed),
        "hours": results.hours,
        "on_floor": math.fsum(one.on_floor for one in rows),
        "near": math.fsum(one.near for one in rows),
        "count": count,
        "contacts": sum(int(n) for n in results.columns.get("contacts", ()) if n is not None),
        "share_with_violation": _interval([float(one.count > 0) for one in rows]),
        "worst": findings.worst,
        "expects": any(trial.expect for trial in study.trials),
        "met": sum(n == 0 for n in unmet),
        "judged": len(unmet),
        "varied": _varied(study),
        "trials": [
            about(scene, trial)
            | {
                "maps": _maps(findings, number, scene),
                "exposed": _exposure(results, findings, trial),
            }
            for number, (trial, scene) in enumerate(zip(study.trials, scenes, strict=True))
        ],
        "all_rules": [one.trial.rules for one in study.combinations],
        "held": _laws(study, scenes),
        **measures_shown(compared),
        "swings": [
            (measure.label, *(_swing(effects, factor) for factor in compared.factors))
            for measure, effects in trends
        ],
        "charts": [(measure, chart) for measure, chart in drawn if chart is not None],
        "shares": _shares(compared, findings),
        **_worst_run(study, findings),
        "software": software(),
        "digests": [*identity(study).items()],
        "results_digest": hashlib.sha256((results.folder / RESULTS).read_bytes()).hexdigest()[:16],
    }


def _with_slack(verdict: Verdict) -> str:
    slack = verdict.slack_in_words
    words = f"{verdict.expected}; {verdict.found}"
    return f"{words}; slack {slack}" if slack else words


def _swing(trends: Sequence[Trend], factor: str) -> str:
    return next((figure(one.swing) for one in trends if one.factor == factor), "–")


def _interval(shares: Sequence[float]) -> str:
    """Return a share of runs with its interval as text."""
    if not shares:
        return "–"
    estimate = share(shares)
    value, low, high = (
        percent(one, digits=1) for one in (estimate.value, estimate.low, estimate.high)
    )
    return f"{sum(shares):.0f} of {len(shares):,}: {value} ({low.removesuffix(' %')} … {high})"


def _varied(study: Study) -> list[tuple[str, str]]:
    rows = [(what.name, ", ".join(map(str, values))) for what, values in study.grid.items()]
    rows += [(what.name, f"drawn: {drawn}") for what, drawn in study.random.items()]
    return [*rows, ("each combination", f"{study.repeat:,} times, seed {study.seed}")]


def _laws(study: Study, scenes: Sequence[Scene]) -> list[LawInUse]:
    """Return each law once, with the number of its combinations."""
    numbers: Counter[LawInUse] = Counter()
    each = len(study.combinations) // len(study.trials)
    for k, combination in enumerate(study.combinations):
        rules, machines = combination.trial.rules, scenes[k // each].machines
        for key in dict.fromkeys(rules.law_and_key_of(machine)[0] for machine in machines):
            mine = [one for one in machines if rules.law_and_key_of(one)[0] == key]
            numbers.update(laws_of(rules, mine))
    every = len(study.combinations)
    return [
        law._replace(machines=f"{law.machines}, in {count} of {every} combinations")
        if count < every
        else law
        for law, count in numbers.items()
    ]


def _shares(compared: Comparison, findings: Findings) -> list[tuple[str, ...]]:
    """Return the share of runs with a violation in each combination."""
    rows = []
    for group in compared.groups:
        mine = [findings.rows[row] for row in group.rows.tolist() if row in findings.rows]
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
    return rows


def _maps(findings: Findings, number: int, scene: Scene) -> list[Picture]:
    maps = findings.maps.get(number, {})
    return risk_pictures(scene.floorplan, scene.machines, maps, scene.trial)


def _exposure(results: StudyResults, findings: Findings, trial: Trial) -> dict[str, Any]:
    """Return the mean exposure to each zone per run."""
    lines = [k for k, name in enumerate(results.columns.get("trial", [])) if name == trial.name]
    mine = [findings.rows[k] for k in lines if k in findings.rows]
    n = max(1, len(mine))
    zones = {
        zone.name: {
            key: math.fsum(one.zones[zone.name][key] for one in mine) / n
            for key in ("time_occupied", "entries", "time_too_close")
        }
        for zone in trial.floorplan.zones
    }
    there, near = (sum(getattr(one, key) for one in mine) / n for key in ("on_floor", "near"))
    return exposure(trial.floorplan, zones, there, near)


def _worst_run(study: Study, findings: Findings) -> dict[str, Any]:
    """Return the pictures and the parameters of the run with the worst violation."""
    if not findings.worst:
        return {}
    number = findings.worst[0][0]
    row = study.row(number)
    mine = [one for n, one in findings.worst if n == number]
    values = [f"{name} {_in_words(value)}" for name, value in row.parameters.items()]
    since = findings.warm_up_of(row.trial)
    return {
        "shown": run_pictures(run(row.trial), mine, "worst", since=since),
        "worst_values": ", ".join(values),
    }


def _in_words(value: object) -> str:
    """Return the text of a parameter."""
    return significant(value) if isinstance(value, float) else str(value)


Progress = Callable[[int], None]


def safety_report(
    source: Recorded | StudyResults,
    path: str | Path,
    *,
    jobs: int | None = None,
    progress: Progress = lambda _: None,
    warm_up: float | None = None,
    sign_off: SignOff = UNSIGNED,
) -> None:
    """Write a report of assumptions, rules, results, violations and limitations.

    Parameters
    ----------
    source : Run or StudyResults
        A run, or the results of a study, whose rows are then run again.
    path : str or Path
        File that ends in .html or .pdf. The latter needs Chromium or Chrome.
    jobs : int, optional
        Number of processes. Defaults to the number of cores.
    progress : callable, optional
        Function called with the number of finished rows.
    warm_up : float, optional
        Time in seconds before which nothing counts. Defaults to that of the trial.
    sign_off : SignOff, optional
        Entries of the sign-off block. Empty entries have the values of the trial.

    Raises
    ------
    ValueError
        If the suffix is unknown, or the warm-up is not shorter than the run.
    OutputError
        If the file cannot be written.
    """
    path = Path(path)
    require_writable(path)
    if isinstance(source, StudyResults):
        title, count = source.study.name, counted(len(source), "run")
        subtitle = f"A study of {count}, simulated by Floorwalker"
        evaluated = findings(
            source.study,
            {*source.failed},
            len(source),
            jobs=jobs,
            progress=progress,
            warm_up=warm_up,
        )
        template = "safety_study.html"
        values = study_report(source, evaluated) | _shared(source, evaluated, sign_off)
    else:
        require(source, Recorded, "sim.load_run")
        title = source.scene.trial
        subtitle = f"A run of {clock(source.duration)} (h:mm:ss), simulated by Floorwalker"
        template, values = "safety_run.html", _of_run(source, warm_up, sign_off)
    with writing(path):
        write_safety_page(path, template, title=title, subtitle=subtitle, **values)


def _shared(source: StudyResults, findings: Findings, sign_off: SignOff) -> dict[str, Any]:
    """Return the warm-up, the stops and the sign-off block of a study's report."""
    trials = source.study.trials
    times = [one.times for one in findings.rows.values()]
    idle = [without_a_job(mine, len(trials[0].people)) for mine in times]
    ends = [findings.warm_up_of(trial) for trial in trials]
    return {
        "warm_ups": ", ".join(f"{end:g} s" for end in dict.fromkeys(ends) if end),
        "stops": stops_in_tables(times_of_all(times), max(1, len(times))),
        "without_a_job": Counter(name for mine in idle for name in mine),
        "sign_off": [*sign_off_rows(sign_off.over(trials[0].sign_off))],
        "signed_by": SIGNED_BY,
    }


def _of_run(source: Recorded, warm_up: float | None, sign_off: SignOff) -> dict[str, Any]:
    trial = source.trial if isinstance(source, Run) else None
    if warm_up is None:
        warm_up = 0.0 if trial is None else trial.warm_up
    if not 0 <= warm_up < max(source.duration, sys.float_info.min):
        raise UserError(
            f"the warm-up must be less than the duration of the run, {source.duration:g} s, not"
            f" {warm_up:g} s"
        )
    if trial is not None:
        sign_off = sign_off.over(trial.sign_off)
    digests = {"what happened": _digest(source)}
    if not isinstance(source, Run):
        return run_report(source, None, digests=digests, warm_up=warm_up, sign_off=sign_off)
    trial = source.trial
    with suppress(ValueError):  # trials made in Python may have no file
        digests = {f"the trial {trial.name}": digest(trial.to_yaml(trial.folder))} | digests
    digests = {"floorwalker": version("floorwalker")} | parts([trial]) | digests
    verdicts = [(_with_slack(one), one.met) for one in source.verdicts]
    return run_report(
        source, trial, digests=digests, verdicts=verdicts, warm_up=warm_up, sign_off=sign_off
    )


def _digest(source: Recorded) -> str:
    """Return a digest of the events and motions of a run."""
    digest = hashlib.sha256(json.dumps(source.events, default=str).encode())
    for name, motion in source.motions.items():
        digest.update(f"{name} {[tuple(piece) for piece in motion.pieces]!r}".encode())
    return digest.hexdigest()[:16]
