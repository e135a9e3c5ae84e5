"""Trial files as tests: collected if they expect something, failed if it is not met."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import floorplan
from floorplan import Document

from ..core.own_source import is_ours
from ..core.scenario import TrialError
from ..trials.comparison import Verdict
from ..trials.trial import Trial, build
from .failures import Failures


class UnmetError(Exception):
    """A trial whose run was not as expected."""


class TrialFile(pytest.File):
    """A trial file."""

    def collect(self) -> Iterator[pytest.Item]:
        """One test, if the trial expects something; one that can't be run is an error."""
        try:
            document = floorplan.read_yaml(self.path, TrialError)
            own_code = not self.config.getoption("--no-own-code")
            trial = build(Trial, document, self.path.parent, own_code)
            if "expect" in document.data:
                yield TrialItem.from_parent(self, name=trial.name, trial=trial, document=document)
        except Exception as why:
            if not is_ours(why) and not isinstance(why, OSError):
                raise
            raise self.CollectError(str(why)) from None


class TrialItem(pytest.Item):
    """The run of a trial, and what is expected of it."""

    def __init__(self, *, trial: Trial, document: Document, **given: Any) -> None:
        super().__init__(**given)
        self.trial = trial
        self._document = document
        self._failures = Failures(self)

    def runtest(self) -> None:
        """Run the trial, and check what it expects."""
        run = self._failures.run(self.trial)
        if run.unmet:
            raise UnmetError

    def teardown(self) -> None:
        """Let go of the run: its report has been made."""
        self._failures.runs.clear()

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """Return what was expected, what happened instead and when, and the replay page's path."""
        if isinstance(excinfo.value, UnmetError):
            return self._unmet()
        if is_ours(excinfo.value):
            pages = [f"replay: {self._failures.page(k)}" for k in range(len(self._failures.runs))]
            return "\n".join([str(excinfo.value), *pages])
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int | None, str]:
        """The file, the line (from 0) of what it expects, and the trial's name."""
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
        if verdict.time is not None:
            yield f"  when:     t = {verdict.time:.3f} s"

    def _line(self, place: tuple[str | int, ...]) -> int:
        return self._document.problem("", "expect", *place).line or 1
