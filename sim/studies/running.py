"""Running a study: rows on many processes, results in their order, as they come."""

from __future__ import annotations

import os
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TypeVar

from floorplan import require

from ..core.folder_names import folder_for
from .backends import backend as on_backend
from .definition import Row
from .folder import RESULTS, StudyFolder, writing_to
from .measuring import measure
from .parquet import write_parquet
from .report import write_report
from .results import StudyResults
from .study import Study
from .table import read_table

AHEAD = "4 * n_jobs"
"""Number of rows handed out before their results are asked for, as joblib reads it."""

Found = TypeVar("Found")

Progress = Callable[[int], None]
"""Is called with the number of rows that are done."""


class WorkerError(RuntimeError):
    """A process that ran rows of a study came to an end."""


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
            one = partial(measure, with_metrics=study.metrics)
            for record in of_rows(one, study.rows(done), jobs, backend):
                with writing_to(path):
                    folder.table.add(record)
                progress(folder.table.rows)
            folder.check_unchanged()
        results = StudyResults(study, path, read_table(path / RESULTS))
        with writing_to(path):
            write_parquet(results.columns, path / "results.parquet")
            write_report(results, path / "report.html")
    return results


def of_rows(
    work: Callable[[Row], Found], rows: Iterable[Row], jobs: int | None, backend: str = "loky"
) -> Iterator[Found]:
    """Yield what `work` finds of each of some rows, in their order, on `jobs` processes.

    `WorkerError` if a process dies.
    """
    import joblib
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    with on_backend(backend, jobs or os.cpu_count() or 1), _without_noise():
        parallel = joblib.Parallel(return_as="generator", pre_dispatch=AHEAD)
        one = joblib.delayed(work)
        found = parallel(one(row) for row in rows)
        try:
            yield from found
        except TerminatedWorkerError:
            raise WorkerError(
                "a worker process was killed or ran out of memory; what is done is kept:"
                " run the same command to go on, with fewer --jobs if memory is short"
            ) from None
        finally:
            found.close()


@contextmanager
def _without_noise() -> Iterator[None]:
    """Keep joblib's remarks on its workers, which are of no use, from the user.

    That one was started anew; and, when rows are taken back, that loky's thread missed one.
    """
    usual = threading.excepthook

    def hook(why: threading.ExceptHookArgs) -> None:
        loky = why.thread is not None and why.thread.name == "ExecutorManagerThread"
        if not (loky and why.exc_type is KeyError):
            usual(why)

    threading.excepthook = hook
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", category=UserWarning, module="joblib")
            yield
    finally:
        threading.excepthook = usual
