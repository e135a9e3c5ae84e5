"""Safety reports of runs and studies, as HTML or PDF."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path

from floorplan import require

from ..core.output import writing
from ..runs.run import Recorded, Run
from ..views.safety_report.assumptions import counted
from ..views.safety_report.of_run import run_sections
from ..views.safety_report.page import require_writable, write_safety_page
from ..views.safety_report.parts import Section, clock
from .findings import findings
from .identity import identity
from .results import StudyResults
from .safety_sections import study_sections
from .study import Study

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
