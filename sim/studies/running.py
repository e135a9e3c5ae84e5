"""Execution of many trials: backends, worker processes, progress, and the figures of rows."""

from __future__ import annotations

import logging
import math
import os
import signal
import threading
import traceback
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, overload

from floorplan import UserError
from floorplan.files.values import require

from ..core.compilation import notice_uncompiled
from ..core.custom_code import DEFECT, is_ours
from ..record.figures import FIGURES
from ..record.output import folder_for
from ..record.social_metrics import metrics
from ..runs.run import Run
from ..simulation import run
from ..trials.trial import Trial
from .comparison import SLACK, StudyResults
from .design import Row, Study
from .folder import StudyFolder, writing_to
from .report import write_report
from .table import Record, plain, write_parquet

if TYPE_CHECKING:
    from joblib import Parallel


AHEAD = "4 * n_jobs"
"""Number of trials that are submitted in advance, in joblib's notation."""

QUIET = "ignore:resource_tracker:UserWarning"
"""Filter for the warnings of loky's resource tracker."""


@contextmanager
def backend_of(name: str, jobs: int) -> Iterator[Parallel]:
    """Yield a `Parallel` of the backend `name`, which yields results in order.

    "dask" uses the cluster of the current client. Without a client it uses the cluster at
    DASK_SCHEDULER_ADDRESS, or `jobs` local processes. `ValueError` if the backend is unknown or its
    packages are missing. Other users of joblib are not affected.
    """
    notice_uncompiled()
    import joblib

    if name == "dask":
        with _without_logs("distributed", "tornado.application", "asyncio"), _dask_client(jobs):
            with joblib.parallel_config(backend="dask"):
                parallel = joblib.Parallel(return_as="generator", pre_dispatch=AHEAD)
            yield parallel
        return
    own = {}
    if name == "loky":
        own = {"initializer": _leave_interrupts_to_the_main_process}
        if jobs != 1:
            _start_quiet_tracker()
    with joblib.parallel_config(backend=name, n_jobs=jobs, **own):
        parallel = joblib.Parallel(return_as="generator", pre_dispatch=AHEAD)
    yield parallel


def _leave_interrupts_to_the_main_process() -> None:
    """Ignore Ctrl-C, because the main process stops the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _start_quiet_tracker() -> None:
    """Start loky's process that tracks semaphores, without its warnings.

    An interrupt may leave semaphores that the process cleans up with a warning. Users can do
    nothing about them.
    """
    from joblib.externals.loky.backend import resource_tracker

    before = os.environ.get("PYTHONWARNINGS")
    os.environ["PYTHONWARNINGS"] = ",".join(filter(None, [before, QUIET]))
    try:
        resource_tracker.ensure_running()
    finally:
        if before is None:
            del os.environ["PYTHONWARNINGS"]
        else:
            os.environ["PYTHONWARNINGS"] = before


@contextmanager
def _without_logs(*names: str) -> Iterator[None]:
    """Silence these logs, because failures are raised as errors."""
    loggers = [logging.getLogger(name) for name in names]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


@contextmanager
def _dask_client(jobs: int) -> Iterator[None]:
    """Provide a Dask client in this context: the current one or a new one."""
    try:
        import dask
        from distributed import Client, LocalCluster, get_client
    except ImportError:
        raise UserError("the backend dask needs: pip install 'floorwalker[dask]'") from None
    try:
        get_client()
    except ValueError:
        pass
    else:
        yield
        return
    if dask.config.get("scheduler-address", None):
        with Client():
            yield
        return
    with _leaving_interrupts_to_this_process():
        cluster = LocalCluster(
            n_workers=jobs,
            threads_per_worker=1,
            # Without an address Dask takes port 8787, and warns if it is taken.
            dashboard_address="localhost:0",
            silence_logs=logging.CRITICAL,
        )
    with cluster, Client(cluster):
        yield


@contextmanager
def _leaving_interrupts_to_this_process() -> Iterator[None]:
    """Start processes in this context that ignore Ctrl-C."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread handles Ctrl-C
        return
    usual = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)


Kept = TypeVar("Kept")
Failed = Callable[[Exception], Kept]

_END: Any = object()

_LABEL: ContextVar[str] = ContextVar("label", default="")
"""Prefix of the warnings of the current trial."""


class WorkerError(RuntimeError):
    """Error of a process that ended while it ran trials."""


@overload
def run_many(
    trials: Iterable[Trial], *, jobs: int | None = None, backend: str = "loky"
) -> Iterator[Run]: ...


@overload
def run_many(
    trials: Iterable[Trial],
    *,
    keep: Callable[[Run], Kept],
    failed: Callable[[Exception], Kept] | None = None,
    jobs: int | None = None,
    backend: str = "loky",
    label: Callable[[], str] = lambda: "",
) -> Iterator[Kept]: ...


def run_many(
    trials: Iterable[Trial],
    *,
    keep: Callable[[Run], Any] | None = None,
    failed: Callable[[Exception], Any] | None = None,
    jobs: int | None = None,
    backend: str = "loky",
    label: Callable[[], str] = lambda: "",
) -> Iterator[Any]:
    """Run trials in parallel and yield their runs in order.

    The runs do not depend on the number of processes. Each process prepares a floor once.

    Parameters
    ----------
    trials : iterable of Trial
        Trials. The iterable may be infinite, because only a few are taken in advance.
    keep : callable, optional
        Function applied to each run in its process. Its result is yielded instead of the run, which
        is large to transfer.
    failed : callable, optional
        Function applied to the exception of a trial. Its result is yielded instead of a run. By
        default the exception is raised when its turn comes.
    jobs : int, optional
        Number of processes. Defaults to the number of cores.
    backend : str, optional
        Backend of joblib. "dask" uses the current `dask.distributed` client or a local cluster.
    label : callable, optional
        Function that returns the prefix of warnings for the trial taken last.

    Yields
    ------
    Run or object
        Run, or the result of `keep` or `failed`.

    Raises
    ------
    ValueError
        If the backend is unknown.
    WorkerError
        If a process dies.

    Examples
    --------
    >>> trial = sim.Trial.load("ariac2023")
    >>> trials = [replace(trial, seed=seed) for seed in range(2)]
    >>> list(sim.run_many(trials, keep=lambda run: run.summary["penalties"], jobs=1))
    [9, 9]
    """
    import joblib
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    one = joblib.delayed(left_of)
    with backend_of(backend, jobs or os.cpu_count() or 1) as parallel:
        results = parallel(one(trial, keep, failed, label()) for trial in trials)
        try:
            while True:
                with without_noise():
                    result = next(results, _END)
                if result is _END:
                    break
                yield result
        except TerminatedWorkerError:
            raise WorkerError(
                "a worker process was killed or ran out of memory;"
                " use fewer jobs if memory is short"
            ) from None
        finally:
            with without_noise():
                results.close()


def left_of(
    trial: Trial,
    keep: Callable[[Run], Any] | None,
    failed: Callable[[Exception], Any] | None,
    label: str,
) -> Any:
    """Return the result of `keep` for the run of a trial, or of `failed` for its error."""
    token = _LABEL.set(label)
    logging.getLogger("bdi").addFilter(_labelled)
    try:
        finished = run(trial)
    except Exception as why:  # custom controllers and laws may raise anything
        if failed is None:
            raise
        return failed(why)
    finally:
        _LABEL.reset(token)
    return finished if keep is None else keep(finished)


def _labelled(warning: logging.LogRecord) -> bool:
    """Put the label of the current trial before a warning."""
    warning.msg = f"{_LABEL.get()}{warning.msg}"
    return True


@contextmanager
def without_noise() -> Iterator[None]:
    """Hide joblib's messages about its workers, which users cannot act on.

    These are warnings about restarted workers, and a `KeyError` in loky's thread after a
    cancellation.
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


Found = TypeVar("Found")

Progress = Callable[[int], None]
"""Function called with the number of finished rows."""


def run_study(
    study: Study,
    out: str | Path | None = None,
    *,
    jobs: int | None = None,
    backend: str = "loky",
    begin: Progress = lambda _: None,
    progress: Progress = lambda _: None,
) -> StudyResults:
    """Run the rows of a study that are not in its folder yet.

    Each row is written to `results.jsonl` when it and all earlier rows are done, so that an
    interrupted study can be continued. In the end all rows are written to `results.csv`. The
    results do not depend on the number of processes.

    Parameters
    ----------
    study : Study
        The study.
    out : str or Path, optional
        Folder. Defaults to `studies/NAME`.
    jobs : int, optional
        Number of processes. Defaults to the number of cores.
    backend : str, optional
        Backend of joblib. See `run_many`.
    begin, progress : callable, optional
        Functions called with the number of finished rows, at the begin and after each change.

    Returns
    -------
    StudyResults
        The results.

    Raises
    ------
    OutputError
        If the folder contains another study, or if custom code was changed during the study.
    WorkerError
        If a process dies.
    """
    require(study, Study, "sim.Study.load")
    path = folder_for(study.name, "studies") if out is None else Path(out)
    with StudyFolder(path, study) as folder:
        done = folder.table.rows
        begin(done)
        if done < len(study) and not _is_enough(study, folder):
            keep = partial(figures_of, with_metrics=study.metrics)
            rows = of_rows(study.rows(done), keep, error_in, jobs=jobs, backend=backend)
            for row, figures in rows:
                with writing_to(path):
                    folder.table.add(record_of(row, figures))
                progress(folder.table.rows)
                if _is_enough(study, folder):
                    break
            folder.check_unchanged()
        results = StudyResults(study, path, folder.table.columns())
        with writing_to(path):
            write_parquet(results.columns, path / "results.parquet")
            write_report(results, path / "report.html")
    return results


def _is_enough(study: Study, folder: StudyFolder) -> bool:
    """Return whether the rows of the folder make every interval narrow enough for the study."""
    until = study.until
    repetitions, rest = divmod(folder.table.rows, len(study.combinations))
    if until is None or rest or repetitions < until.at_least:
        return False
    results = StudyResults(study, folder.path, folder.table.columns())
    return results.width(until.of) <= until.width


def of_rows(
    rows: Iterable[Row],
    keep: Callable[[Run], Found],
    failed: Callable[[Exception], Found] | None = None,
    *,
    jobs: int | None,
    backend: str = "loky",
) -> Iterator[tuple[Row, Found]]:
    """Yield each row with the result of `run_many`, in order.

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
        for result in many:
            yield under_way.popleft(), result
    except WorkerError as why:
        hint = "what is done is kept: run the same command to go on"
        raise WorkerError(f"{why}; {hint}") from None


_LEFT_OUT = frozenset(path for path, figure in FIGURES.items() if not figure.column)


def figures_of(finished: Run, *, with_metrics: bool = False) -> Record:
    """Return the figures of the summary of a run, and its metrics if requested.

    They do not depend on time or machine.
    """
    summary = {key: value for key, value in finished.summary.items() if key not in _LEFT_OUT}
    if with_metrics:
        summary["metrics"] = metrics(finished)
    slacks = {".".join(map(str, one.place)): one.slack for one in finished.verdicts}
    figures: Record = {"error": None, "unmet": len(finished.unmet)} | dict(flat(summary))
    return figures | {
        f"{SLACK}.{key}": None if math.isinf(slack) else slack for key, slack in slacks.items()
    }


def error_in(why: Exception) -> Record:
    """Return the record of a failed trial: its error on one line.

    Defects of Floorwalker are marked and have their place in the code.
    """
    words = f"{type(why).__name__}: {why}"
    if not is_ours(why) and not isinstance(why, OSError):
        at = traceback.extract_tb(why.__traceback__)[-1]
        words = f"{DEFECT}: {words} ({Path(at.filename).name}, line {at.lineno})"
    return {"error": " ".join(words.split())}


def record_of(row: Row, figures: Record) -> Record:
    """Return the record of `row`: its number, parameters, and figures or error."""
    record: Record = {"row": row.number}
    record |= {name: plain(value) for name, value in row.parameters.items()}
    return record | figures


def flat(figures: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Yield nested figures with names joined by dots. Lists are given by length."""
    for key, value in figures.items():
        name = f"{above}{key}"
        if isinstance(value, Mapping):
            yield from flat(value, f"{name}.")
        elif isinstance(value, list | tuple):
            yield name, len(value)
        else:
            yield name, value
