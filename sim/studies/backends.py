"""Backends on which many trials run: those of joblib, Dask's cluster among them."""

from __future__ import annotations

import logging
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from floorplan import UserError

if TYPE_CHECKING:
    from joblib import Parallel

AHEAD = "4 * n_jobs"
"""Number of trials handed out before their results are asked for, as joblib reads it."""

QUIET = "ignore:resource_tracker:UserWarning"
"""The warnings of loky's resource tracker, as a filter of Python's."""


@contextmanager
def backend(name: str, jobs: int) -> Iterator[Parallel]:
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
