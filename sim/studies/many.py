"""Many trials, run on many processes: what is left of them, in their order."""

from __future__ import annotations

import logging
import os
import threading
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, TypeVar, overload

from ..runs.run import Run
from ..simulation import run
from ..trials.trial import Trial
from .backends import backend as on_backend

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
    with on_backend(backend, jobs or os.cpu_count() or 1) as parallel:
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
