"""Where rows of a study run: joblib's backends, and Dask's cluster among them."""

from __future__ import annotations

import logging
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def backend(name: str, jobs: int) -> Iterator[None]:
    """joblib set to run on the backend called `name` in this context.

    "dask" runs on the cluster of the current client; where there is none, on the one that
    DASK_SCHEDULER_ADDRESS names, or on `jobs` local processes. `ValueError` if there is no such
    backend or what it needs is not installed.
    """
    import joblib

    if name == "dask":
        with _without_logs("distributed", "tornado.application", "asyncio"), _dask_client(jobs):
            yield
        return
    own = {"initializer": _leave_interrupts_to_the_main_process} if name == "loky" else {}
    with joblib.parallel_config(backend=name, n_jobs=jobs, **own):
        yield


def _leave_interrupts_to_the_main_process() -> None:
    """A terminal's Ctrl-C goes to all processes; one of them is enough to stop the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _without_logs(*names: str) -> Iterator[None]:
    """Keep these logs silent: what goes wrong comes as an error, and is told once."""
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
    import joblib

    try:
        import dask
        from distributed import Client, LocalCluster, get_client
    except ImportError:
        raise ValueError("the backend dask needs: pip install 'floorwalker[dask]'") from None
    try:
        get_client()
    except ValueError:
        pass
    else:
        with joblib.parallel_config(backend="dask"):
            yield
        return
    if dask.config.get("scheduler-address", None):
        with Client(), joblib.parallel_config(backend="dask"):
            yield
        return
    with _leaving_interrupts_to_this_process():
        cluster = LocalCluster(
            n_workers=jobs,
            threads_per_worker=1,
            dashboard_address=None,
            silence_logs=logging.CRITICAL,
        )
    with cluster, Client(cluster), joblib.parallel_config(backend="dask"):
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
