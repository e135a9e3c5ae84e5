"""Trial files as pytest items, and reports of failed runs."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from floorplan.files.collector import frozen_collector
from floorplan.files.documents import Document, read_yaml

from ..core.custom_code import CodeFolder, is_ours
from ..core.scenario import TrialError
from ..core.wording import distinguished
from ..record.output import write_whole
from ..record.summary import trial_figures_in_words
from ..runs.run import Run
from ..simulation import Simulation
from ..trials.building import build
from ..trials.names import in_words
from ..trials.timeline import Verdict
from ..trials.trial import Trial
from ..views.replay import render
from ..views.replay_data import replay_data

_LONGEST_NAME = 120
"""Maximum number of characters of a page's file name."""

_MOST_VIOLATIONS = 5
"""Maximum number of violations of a run in a report."""


class Failures:
    """Runs the trials of one test, and keeps the data of failures."""

    def __init__(self, item: pytest.Item) -> None:
        self.runs: list[Run] = []
        self._item = item

    def run(self, trial: Trial) -> Run:
        """Run `trial` to its end. The record is kept even if custom code fails."""
        __tracebackhide__ = True
        try:
            with frozen_collector():
                simulation = Simulation(trial)
                try:
                    simulation.advance(trial.duration)
                finally:
                    self.runs.append(simulation.finish())
        except Exception as why:
            if not is_ours(why):
                raise
            # Its message contains the place, which frames of the event loop do not.
            raise why.with_traceback(None) from None
        return self.runs[-1]

    def report(self) -> str:
        """Return the result of each run in words, with the path of its replay page."""
        return "\n\n".join(
            "\n".join([*_outline(run), f"replay: {self.page(k)}"])
            for k, run in enumerate(self.runs)
        )

    def page(self, k: int) -> str:
        """Write the replay page of run `k`. Return its path, or the reason why there is none."""
        folder = replay_folder(self._item.config)
        if folder is None:
            return "none kept; give a folder with --floorwalker-replays DIR"
        page = folder / _file_name(self._item.nodeid, k)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            write_whole(page, render(replay_data(self.runs[k])))
        except OSError as why:
            return f"can't be written to {folder}: {why.strerror}"
        return str(page)


def replay_folder(config: pytest.Config) -> Path | None:
    """Return the folder for replay pages: the requested one, or one in pytest's cache."""
    chosen = config.getoption("--floorwalker-replays")
    if chosen:
        return Path(config.invocation_params.dir, chosen)
    cache = getattr(config, "cache", None)
    return None if cache is None else Path(cache.mkdir("floorwalker-replays"))


def _outline(run: Run) -> list[str]:
    """Return a summary of a run in a few lines: bodies, results and unmet expectations."""
    trial, summary = run.trial, run.summary
    gantry = f"gantry {trial.gantry.controller_name}; " if trial.floorplan.gantry else ""
    figures = [f"{figure} {amount}" for figure, amount in trial_figures_in_words(summary)]
    lines = [
        f"{trial.name} on {trial.floorplan.name}, {run.duration:g} s: {in_words(trial)};"
        f" {gantry}rules {trial.rules.name}; seed {trial.seed}",
        *filter(None, ["; ".join(figures)]),
    ]
    violations = [event for event in run.events if event["kind"] == "violation"]
    for event in violations[:_MOST_VIOLATIONS]:
        distance, required = distinguished(event["distance"], event["required"])
        lines.append(
            f"violation at t = {event['t']:.3f} s: {event['person']} and {event['with']}"
            f" {distance} m apart, {required} m required"
        )
    if len(violations) > _MOST_VIOLATIONS:
        more = len(violations) - _MOST_VIOLATIONS
        lines.append(f"and {more} more violation{'s' * (more > 1)}")
    return lines + run.unmet


def _file_name(nodeid: str, k: int) -> str:
    """Return a unique name of the page of a test's run."""
    readable = re.sub(r"[^\w.-]+", "_", nodeid)[-_LONGEST_NAME:].strip("_")
    number = f"-{k + 1}" if k else ""
    return f"{readable}-{zlib.crc32(nodeid.encode()):08x}{number}.html"


class UnmetError(Exception):
    """Error of a trial whose expectations were not met."""


class TrialFile(pytest.File):
    """A trial file."""

    def collect(self) -> Iterator[pytest.Item]:
        """Return one test, if the trial has expectations. An invalid trial is an error."""
        try:
            document = read_yaml(self.path, TrialError)
            own_code = not self.config.getoption("--no-own-code")
            trial = build(Trial, document, CodeFolder(self.path.parent, own_code))
            if "expect" in document.data:
                yield TrialItem.from_parent(self, name=trial.name, trial=trial, document=document)
        except Exception as why:
            if not is_ours(why) and not isinstance(why, OSError):
                raise
            raise self.CollectError(str(why)) from None


class TrialItem(pytest.Item):
    """The run of a trial, and its expectations."""

    def __init__(self, *, trial: Trial, document: Document, **arguments: Any) -> None:
        super().__init__(**arguments)
        self.trial = trial
        self._document = document
        self._failures = Failures(self)

    def runtest(self) -> None:
        """Run the trial, and check its expectations."""
        run = self._failures.run(self.trial)
        if run.unmet:
            raise UnmetError

    def teardown(self) -> None:
        """Release the run after its report."""
        self._failures.runs.clear()

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Return the unmet expectations with values and times, and the path of the replay page."""
        if isinstance(excinfo.value, UnmetError):
            return self._unmet()
        if is_ours(excinfo.value):
            pages = [f"replay: {self._failures.page(k)}" for k in range(len(self._failures.runs))]
            return "\n".join([str(excinfo.value), *pages])
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """Return the file, the line (from 0) of the expectations, and the name of the trial."""
        return self.path, self._line(()) - 1, f"trial {self.name}"

    def _unmet(self) -> str:
        (run,) = self._failures.runs
        unmet = [verdict for verdict in run.verdicts if not verdict.met]
        lines = [f"{len(unmet)} of {len(run.verdicts)} expectations not met in {run.duration:g} s"]
        for verdict in unmet:
            lines += ["", *self._told(verdict)]
        return "\n".join([*lines, "", f"replay: {self._failures.page(0)}"])

    def _told(self, verdict: Verdict) -> Iterator[str]:
        yield f"{self.path.name}:{self._line(verdict.place)}"
        yield f"  expected: {verdict.expected}"
        yield f"  happened: {verdict.found}"
        if slack := verdict.slack_in_words:
            yield f"  slack:    {slack}"
        if verdict.time is not None:
            yield f"  when:     t = {verdict.time:.3f} s"

    def _line(self, place: tuple[str | int, ...]) -> int:
        return self._document.problem("", "expect", *place).line or 1
