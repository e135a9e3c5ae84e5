"""Worst-case search: evaluate batches of trials, and minimise the worst distinct ones."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from floorplan import UserError
from floorplan.files.collector import frozen_collector
from floorplan.files.dataclass import dataclass
from floorplan.files.values import require

from ..core.custom_code import CodeFolder
from ..record.output import folder_for, write_whole
from ..runs.run import Run
from ..simulation import Simulation
from ..studies.code_files import digest_of_code, digest_of_source
from ..studies.design import Study, derived_seed
from ..studies.folder import StudyFolder, writing_to
from ..studies.running import WorkerError, backend_of, left_of, without_noise
from ..studies.table import Record, plain
from ..trials.trial import Trial
from ..trials.writing import out_of_reach
from ..views.replay import render
from ..views.replay_data import replay_data
from .evaluations import (
    SITUATION,
    Evaluation,
    Found,
    Keep,
    distinct,
    evaluation_of,
    failed,
    record,
)
from .minimising import Minimised, Minimiser
from .objective import Objective
from .report import rounded, shown, write_report
from .results import Case, SearchProgress, SearchResults, least
from .samplers import SAMPLER, SAMPLERS, Checked, MakesSampler, find_sampler, told
from .space import Point, Space

if TYPE_CHECKING:
    from joblib import Parallel

Report = Callable[[SearchProgress], None]
"""Function called after each batch."""

STARTUP = 2
"""Number of batches at the beginning that are random."""

CASES = "cases"
"""Folder of the minimised trials."""


@dataclass(frozen=True, kw_only=True)
class WorstCaseSearch:
    """A search of a study, ready to run.

    `random_share` is the random share of each batch. The first batches are random. `cases` is the
    maximum number of distinct cases that are minimised.
    """

    study: Study
    objective: Objective
    sampler: str | MakesSampler = "tpe"
    evaluations: int = 200
    batch: int = 8
    random_share: float = 0.25
    cases: int = 5
    space: Space = field(init=False)

    def __post_init__(self) -> None:
        for name, low in (("evaluations", 1), ("batch", 1), ("cases", 0)):
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool) or value < low:
                raise UserError(f"{name} must be a whole number of at least {low}, not {value!r}")
        if not 0.0 <= self.random_share <= 1.0:
            raise UserError(f"random_share must be from 0 to 1, not {self.random_share!r}")
        object.__setattr__(self, "space", Space(self.study))
        for combination in self.study.combinations:
            self.objective.check(combination.trial)

    @property
    def sampler_name(self) -> str:
        """The sampler's name."""
        name = getattr(self.sampler, "__qualname__", type(self.sampler).__qualname__)
        return self.sampler if isinstance(self.sampler, str) else str(name)

    def is_random(self, number: int) -> bool:
        """Return True if the evaluation of that number is random."""
        at_random = round(self.random_share * self.batch)
        return (
            self.sampler == "random"
            or number < STARTUP * self.batch
            or number % self.batch < at_random
        )

    def folder(self, out: str | Path | None) -> Path:
        """Return the folder of the results. `UserError` if trials cannot be saved there."""
        path = folder_for(self.study.name, "searches") if out is None else Path(out)
        faults = [out_of_reach(trial, path / CASES) for trial in self.study.trials]
        if any(faults) and out is None:  # below the study its code is found again
            return folder_for(self.study.name, str(self.study.folder / "searches"))
        for trial, fault in zip(self.study.trials, faults, strict=True):
            if fault and self.cases:
                raise UserError(f"cases of {trial.name!r} can't be saved in {path}: {fault}")
        return path

    @property
    def code(self) -> CodeFolder:
        """The folder of the study's code."""
        allowed = all(trial.own_code for trial in self.study.trials)
        return CodeFolder(self.study.folder, allowed)

    def identity(self) -> dict[str, str]:
        """Return the texts that decide the evaluations beside the study."""
        terms = [self.objective.minimise, self.objective.slack, self.sampler_name, self.batch]
        digests = {"the search": json.dumps([*terms, self.random_share, STARTUP])}
        if not isinstance(self.sampler, str):
            return digests | {"the sampler": digest_of_code(self.sampler)}
        if self.sampler not in SAMPLERS:
            source = self.code.find(self.sampler, SAMPLER)
            return digests | {"the sampler": digest_of_source(source)}
        return digests


def search(
    study: Study,
    out: str | Path | None = None,
    *,
    minimise: str = "",
    slack: str = "",
    below: float = 0.0,
    sampler: str | MakesSampler = "tpe",
    evaluations: int = 200,
    batch: int = 8,
    random_share: float = 0.25,
    cases: int = 5,
    jobs: int | None = None,
    backend: str = "loky",
    progress: Report = lambda _: None,
) -> SearchResults:
    """Search the trials of a study for the worst ones, and minimise those that break.

    Parameters
    ----------
    study : Study
        Its trials, grid and distributions are what may vary.
    out : path, optional
        Folder of the results. Default: `searches/NAME`. A search that was stopped is resumed.
    minimise, slack : str, optional
        The objective: a figure of the summary, or the name of an expectation of the trial.
    below : float, optional
        A trial breaks if the figure is less. Default: 0.
    sampler : str or callable, optional
        `tpe`, `random`, `package.module:Class`, or a class with methods `ask` and `tell`.
    evaluations : int, optional
        Number of trials to try.
    batch : int, optional
        Number of trials that are evaluated together, whatever the number of processes.
    random_share : float, optional
        Share of random trials in each batch. They alone say at which rate trials break.
    cases : int, optional
        Greatest number of distinct cases to minimise and save.
    jobs : int, optional
        Number of processes. Default: all cores. The results do not depend on it.
    backend : str, optional
        A joblib backend, or `dask`.
    progress : callable, optional
        Is called with a `SearchProgress` after each batch.

    Returns
    -------
    SearchResults

    Raises
    ------
    UserError
        If nothing varies, if the trials do not have the objective, or if a sampler goes wrong.
    OutputError
        If the folder has the results of another search.

    Examples
    --------
    >>> from tempfile import mkdtemp
    >>> study = sim.Study.parse("{trials: [ariac2023], random: {start_time: {uniform: [0, 20]}}}")
    >>> wanted = {"minimise": "least_margin", "evaluations": 4, "cases": 0}
    >>> found = sim.search(study, mkdtemp(), jobs=1, **wanted)
    >>> len(found)
    4
    """
    require(study, Study, "sim.Study.load")
    wanted = WorstCaseSearch(
        study=study,
        objective=Objective(minimise, slack=slack, below=below),
        sampler=sampler,
        evaluations=evaluations,
        batch=batch,
        random_share=random_share,
        cases=cases,
    )
    return run_search(wanted, out, jobs=jobs, backend=backend, progress=progress)


def run_search(
    wanted: WorstCaseSearch,
    out: str | Path | None = None,
    *,
    jobs: int | None = None,
    backend: str = "loky",
    progress: Report = lambda _: None,
) -> SearchResults:
    """Run a search. See `search`."""
    make = find_sampler(wanted.sampler, wanted.code)
    path = wanted.folder(out)
    with StudyFolder(path, wanted.study, wanted.identity()) as folder:
        tried: list[Evaluation] = []
        cases: tuple[Case, ...] = ()
        interrupted = False
        with backend_of(backend, jobs or os.cpu_count() or 1) as parallel:
            try:
                tried.extend(_evaluated(wanted, make, folder, parallel, progress))
                if _worst(wanted, tried):
                    progress(SearchProgress(done=len(tried), best=least(tried), minimising=True))
                cases = _minimised(wanted, tried, path, parallel)
            except KeyboardInterrupt:
                interrupted = True
        folder.check_unchanged()
        results = SearchResults(
            study=wanted.study,
            objective=wanted.objective,
            space=wanted.space,
            folder=path,
            sampler=wanted.sampler_name,
            evaluations=tuple(tried),
            cases=cases or tuple(Case(one) for one in _worst(wanted, tried)),
            interrupted=interrupted,
            notices=tuple(notices(wanted, tried)),
        )
        with writing_to(path):
            write_report(results, path / "report.html")
    return results


def _evaluated(
    wanted: WorstCaseSearch,
    make: MakesSampler,
    folder: StudyFolder,
    parallel: Parallel,
    progress: Report,
) -> Iterator[Evaluation]:
    """Yield the evaluations batch by batch. Evaluations in the folder are not run again."""
    space = wanted.space
    sampler = Checked(make, space, derived_seed("sampler", wanted.study.seed))
    measured = folder.table.records()
    best: Evaluation | None = None
    done = 0
    while done < wanted.evaluations:
        # Only whole batches are requested, so that a search can be extended.
        numbers = range(done, done + wanted.batch)
        proposed = iter(sampler.ask(sum(not wanted.is_random(k) for k in numbers)))
        points = [space.random_point(k) if wanted.is_random(k) else next(proposed) for k in numbers]
        chosen = [*zip(numbers, points, strict=True)][: wanted.evaluations - done]
        batch = []
        for one, outcome in _run(wanted, chosen, measured, parallel):
            batch.append(one)
            if one.number >= folder.table.rows:
                with writing_to(folder.path):
                    folder.table.add(record(one, outcome))
            yield one
        values = [
            None if one.result == "no trial" else told(one.value, failed=one.result == "error")
            for one in batch
        ]
        sampler.tell(points[: len(batch)], values)
        done += len(batch)
        best = least(batch if best is None else [best, *batch])
        progress(SearchProgress(done=done, best=best))
        if done == len(batch):
            _require_a_number(wanted, batch)


def _run(
    wanted: WorstCaseSearch,
    batch: list[tuple[int, Point]],
    measured: Sequence[Record],
    parallel: Parallel,
) -> Iterator[tuple[Evaluation, Found]]:
    """Yield the evaluations of the points of a batch, in their order."""
    import joblib
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    rows: list[tuple[int, Point, Mapping[str, Any], Found | None]] = []
    tasks = []
    one, keep = joblib.delayed(left_of), Keep(wanted.objective)
    for number, point in batch:
        values: Mapping[str, Any] = dict(point)
        outcome: Found | None = None
        try:
            row = wanted.space.row(number, point)
            values = row.parameters
        except (UserError, OSError) as why:
            outcome = {**failed(why), "result": "no trial"}
        if number < len(measured):
            outcome = _repeated(measured[number], number, values, wanted)
        if outcome is None:
            tasks.append(one(row.trial, keep, failed, f"evaluation {number}: "))
        rows.append((number, point, values, outcome))
    try:
        with without_noise():
            results = iter(parallel(tasks)) if tasks else iter(())
            for number, point, values, outcome in rows:
                left = next(results) if outcome is None else outcome
                random = wanted.is_random(number)
                yield evaluation_of(number, point, values, left, is_random=random), left
    except TerminatedWorkerError:
        message = "a worker process was killed or ran out of memory; use fewer jobs"
        raise WorkerError(f"{message}. Run the same command to resume") from None


def _repeated(
    measured: Record, number: int, values: Mapping[str, Any], wanted: WorstCaseSearch
) -> Found:
    """Return the outcome of an evaluation from the table. `UserError` if its values differ."""
    for name, value in values.items():
        cell, written = plain(value), measured.get(name)
        if written != cell:
            raise UserError(
                f"the search can't be resumed: the sampler {wanted.sampler_name} asks for"
                f" {name} {cell} in evaluation {number}, and asked for {written} before;"
                " give another folder with --out"
            )
    return {key: measured[key] for key in ("result", "error", "value", *SITUATION)}


def _require_a_number(wanted: WorstCaseSearch, batch: list[Evaluation]) -> None:
    """Raise `UserError` if no run of the first batch has the objective and none failed."""
    tried = [one for one in batch if one.result != "no trial"]
    if tried and all(one.result == "run" and one.value is None for one in tried):
        raise UserError(
            f"no run of the first batch has a number for {wanted.objective}:"
            " there is nothing to minimise"
        )


def notices(wanted: WorstCaseSearch, tried: list[Evaluation]) -> Iterator[str]:
    """Yield notices about a constant objective and about values that make no trial."""
    runs = [one for one in tried if one.result == "run"]
    values = {one.value for one in runs}
    if len(runs) > 1 and len(values) == 1:
        (value,) = values
        what = "no number" if value is None else f"{value:g}"
        yield f"{wanted.objective} is {what} in all {len(runs)} runs: nothing guides the search"
    if none := [one for one in tried if one.result == "no trial"]:
        first = none[0]
        yield (
            f"{len(none)} of {len(tried)} points make no trial; evaluation {first.number}:"
            f" {first.situation.error}"
        )


def _worst(wanted: WorstCaseSearch, tried: list[Evaluation]) -> list[Evaluation]:
    broken = [one for one in tried if one.is_break(wanted.objective)]
    return distinct(broken, wanted.space.dimensions, wanted.cases)


def _minimised(
    wanted: WorstCaseSearch, tried: list[Evaluation], folder: Path, parallel: Parallel
) -> tuple[Case, ...]:
    """Minimise the worst distinct cases, and save each trial once."""
    import joblib

    worst = _worst(wanted, tried)
    if not worst:
        return ()
    paths = [what.path for what in wanted.study.random if what.path == what.name]
    trials = [wanted.space.row(one.number, one.point).trial for one in worst]
    one = joblib.delayed(_minimise)
    with without_noise():
        smallest = [*parallel(one(trial, wanted.objective, paths) for trial in trials)]
    cases: list[Case] = []
    seen: list[Trial] = []
    for evaluation, smallest_trial in zip(worst, smallest, strict=True):
        if smallest_trial is None:
            cases.append(Case(evaluation))
            continue
        if smallest_trial.trial in seen:
            continue
        seen.append(smallest_trial.trial)
        cases.append(_saved(wanted, evaluation, smallest_trial, folder, len(seen)))
    return tuple(cases)


def _minimise(trial: Trial, objective: Objective, paths: list[str]) -> Minimised | None:
    return Minimiser(trial, objective, paths).minimised()


def _saved(
    wanted: WorstCaseSearch, evaluation: Evaluation, minimised: Minimised, folder: Path, number: int
) -> Case:
    """Write a minimised trial and its replay page."""
    name = f"{wanted.study.name}-{number}"
    place = folder / CASES
    path = place / f"{name.replace('/', '-')}.trial.yaml"
    trial = replace(minimised.trial, name=name)
    case = Case(evaluation, replace(minimised, trial=trial), path)
    with writing_to(place):
        place.mkdir(parents=True, exist_ok=True)
        write_whole(path, f"{_origin(wanted, case)}{trial.to_yaml(place)}")
        assert case.replay is not None
        write_whole(case.replay, render(replay_data(_run_of(trial))))
    return case


def _origin(wanted: WorstCaseSearch, case: Case) -> str:
    """Return comments about the origin of a minimised trial, its replay and its film."""
    evaluation = case.evaluation
    assert case.minimised is not None and case.replay is not None
    value = case.minimised.value
    if value is None:
        what = evaluation.situation.error
    else:
        what = f"{wanted.objective} {rounded(value)}, before minimising {shown(evaluation)}"
    source = f"evaluation {evaluation.number} of the search {wanted.study.name!r}"
    seen = f"Replay: {case.replay.name}. Film: {case.film}"
    return f"# Minimised from {source}:\n# {what}\n# {seen}\n"


def _run_of(trial: Trial) -> Run:
    """Return the run of a trial, which ends where custom code fails."""
    with frozen_collector():
        simulation = Simulation(trial)
        with suppress(Exception):
            simulation.advance(trial.duration)
        return simulation.finish()
