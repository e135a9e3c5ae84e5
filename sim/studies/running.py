"""Running a study: rows on many processes, results in their order, as they come."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import TypeVar

from floorplan import require

from ..core.folder_names import folder_for
from ..runs.run import Run
from ..trials.trial import Trial
from .definition import Row
from .folder import RESULTS, StudyFolder, writing_to
from .many import WorkerError, run_many
from .measuring import error_in, figures_of, record_of
from .parquet import write_parquet
from .report import write_report
from .results import StudyResults
from .study import Study
from .table import read_table

Found = TypeVar("Found")

Progress = Callable[[int], None]
"""Is called with the number of rows that are done."""


def run_study(
    study: Study,
    out: str | Path | None = None,
    *,
    jobs: int | None = None,
    backend: str = "loky",
    begin: Progress = lambda _: None,
    progress: Progress = lambda _: None,
) -> StudyResults:
    """Run every row of `study` that is not in the folder `out` yet (`studies/NAME` by default).

    Rows run on `jobs` processes (all cores by default) of a joblib `backend`; with "dask", on the
    cluster of the current `dask.distributed` client, or a local one. The results don't depend on
    either. Each row is in `results.csv` as soon as it and those before it are done, so that a
    study which is stopped, however roughly, goes on from there when it is run again. How many rows
    are done is given to `begin` before they are run, and to `progress` whenever it changes.
    `OutputError` if the folder holds another study, or if a program or controller was changed
    while it ran; `WorkerError` if a worker process dies.
    """
    require(study, Study, "sim.Study.load")
    path = folder_for(study.name, "studies") if out is None else Path(out)
    with StudyFolder(path, study) as folder:
        done = folder.table.rows
        begin(done)
        if done < len(study):
            keep = partial(figures_of, with_metrics=study.metrics)
            rows = of_rows(study.rows(done), keep, error_in, jobs=jobs, backend=backend)
            for row, figures in rows:
                with writing_to(path):
                    folder.table.add(record_of(row, figures))
                progress(folder.table.rows)
            folder.check_unchanged()
        results = StudyResults(study, path, read_table(path / RESULTS))
        with writing_to(path):
            write_parquet(results.columns, path / "results.parquet")
            write_report(results, path / "report.html")
    return results


def of_rows(
    rows: Iterable[Row],
    keep: Callable[[Run], Found],
    failed: Callable[[Exception], Found] | None = None,
    *,
    jobs: int | None,
    backend: str = "loky",
) -> Iterator[tuple[Row, Found]]:
    """Yield each of some rows with what `run_many` keeps of it, in their order.

    `WorkerError` if a process dies.
    """
    under_way: deque[Row] = deque()

    def trials() -> Iterator[Trial]:
        for row in rows:
            under_way.append(row)
            yield row.trial

    def label() -> str:
        return f"row {under_way[-1].number}: "

    many = run_many(trials(), keep=keep, failed=failed, jobs=jobs, backend=backend, label=label)
    try:
        for found in many:
            yield under_way.popleft(), found
    except WorkerError as why:
        kept = "what is done is kept: run the same command to go on"
        raise WorkerError(f"{why}; {kept}") from None
