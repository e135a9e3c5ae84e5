"""Execution of many trials: backends, worker processes, progress, and the figures of rows."""

from __future__ import annotations

import logging
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

from ..core.custom_code import DEFECT, is_ours
from ..record.figures import FIGURES
from ..record.output import folder_for
from ..record.social_metrics import metrics
from ..runs.run import Run
from ..simulation import run
from ..trials.trial import Trial
from .comparison import StudyResults
from .design import Row, Study
from .folder import RESULTS, Record, StudyFolder, read_table, write_parquet, writing_to
from .report import write_report

if TYPE_CHECKING:
    from joblib import Parallel


AHEAD = "4 * n_jobs"
"""Number of trials handed out before their results are asked for, as joblib reads it."""

QUIET = "ignore:resource_tracker:UserWarning"
"""The warnings of loky's resource tracker, as a filter of Python's."""


@contextmanager
def backend_of(name: str, jobs: int) -> Iterator[Parallel]:
    """Yield what calls functions on the backend called `name`, and yields results in their order.

    "dask" runs on the cluster of the current client; where there is none, on the one that
    DASK_SCHEDULER_ADDRESS names, or on `jobs` local processes. `ValueError` if there is no such
    backend or what it needs is not installed. What else uses joblib meanwhile is not affected.
    """
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
    """A terminal's Ctrl-C goes to all processes; one of them is enough to stop the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _start_quiet_tracker() -> None:
    """Start the process in which loky keeps track of semaphores, without its warnings.

    It warns of those that an interrupt catches between their making and their being forgotten,
    cleans them up, and warns of those that are gone by then: nothing that anybody can use.
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
    """Keep these logs silent: what goes wrong comes as an error, once."""
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
    """See to it that there is a Dask client in this context: the current one, or one of its own."""
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
            # Any port will do: without an address Dask takes 8787, and warns where that is taken.
            dashboard_address="localhost:0",
            silence_logs=logging.CRITICAL,
        )
    with cluster, Client(cluster):
        yield


@contextmanager
def _leaving_interrupts_to_this_process() -> Iterator[None]:
    """Processes that are started in this context take no notice of Ctrl-C."""
    if threading.current_thread() is not threading.main_thread():
        yield  # there is no Ctrl-C in other threads, and no way to say so
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
"""Beginning of the warnings of the trial under way."""


class WorkerError(RuntimeError):
    """A process that ran trials came to an end."""


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
    """Run `trials` and yield their runs in the order of the trials, as they come.

    They run on `jobs` processes (all cores by default) of a joblib `backend`; with "dask", on the
    cluster of the current `dask.distributed` client, or a local one. The runs don't depend on
    either. Each process works out once what belongs to a floor, however many trials are on it;
    `trials` may be endless: no more than a few of each process are taken ahead.

    Runs are large, and have to come from one process to another: `keep` takes each run where it
    was made, and what it returns is yielded in its place. What a trial raises is raised here when
    its turn comes, and ends all; with `failed`, what that makes of the error is yielded instead.
    Warnings of programs begin with the `label` of the trial that was taken last.
    `ValueError` if there is no such backend, `WorkerError` if a process dies.
    """
    import joblib
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    one = joblib.delayed(_left_of)
    with backend_of(backend, jobs or os.cpu_count() or 1) as parallel:
        results = parallel(one(trial, keep, failed, label()) for trial in trials)
        try:
            while True:
                with _without_noise():
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
            with _without_noise():
                results.close()


def _left_of(
    trial: Trial,
    keep: Callable[[Run], Any] | None,
    failed: Callable[[Exception], Any] | None,
    label: str,
) -> Any:
    """Return what is to be kept of the run of a trial, or of its error."""
    token = _LABEL.set(label)
    logging.getLogger("bdi").addFilter(_labelled)
    try:
        finished = run(trial)
    except Exception as why:  # the user's own controllers and laws may raise anything
        if failed is None:
            raise
        return failed(why)
    finally:
        _LABEL.reset(token)
    return finished if keep is None else keep(finished)


def _labelled(warning: logging.LogRecord) -> bool:
    """Put the label of the trial under way before a warning."""
    warning.msg = f"{_LABEL.get()}{warning.msg}"
    return True


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


_LEFT_OUT = frozenset(path for path, figure in FIGURES.items() if not figure.column)


def figures_of(finished: Run, *, with_metrics: bool = False) -> Record:
    """Return the figures of a run: those of its summary, and its metrics if asked for.

    Nothing here depends on where or when it ran.
    """
    summary = {key: value for key, value in finished.summary.items() if key not in _LEFT_OUT}
    if with_metrics:
        summary["metrics"] = metrics(finished)
    return {"error": None, "unmet": len(finished.unmet)} | dict(flat(summary))


def error_in(why: Exception) -> Record:
    """Return what stands in place of figures where a trial failed: what it raised, on one line.

    An error that no input may cause is told apart, and has the place where it arose.
    """
    words = f"{type(why).__name__}: {why}"
    if not is_ours(why) and not isinstance(why, OSError):
        at = traceback.extract_tb(why.__traceback__)[-1]
        words = f"{DEFECT}: {words} ({Path(at.filename).name}, line {at.lineno})"
    return {"error": " ".join(words.split())}


def record_of(row: Row, figures: Record) -> Record:
    """Return the line of `row`: its number, its parameters, and its figures or error."""
    record: Record = {"row": row.number}
    record |= {name: _plain(value) for name, value in row.parameters.items()}
    return record | figures


def flat(figures: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Figures within figures by their names joined with dots; of a list, how long it is."""
    for key, value in figures.items():
        name = f"{above}{key}"
        if isinstance(value, Mapping):
            yield from flat(value, f"{name}.")
        elif isinstance(value, list | tuple):
            yield name, len(value)
        else:
            yield name, value


def _plain(value: Any) -> Any:
    return " ".join(str(one) for one in value) if isinstance(value, tuple) else value
