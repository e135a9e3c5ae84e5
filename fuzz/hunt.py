"""Feed a reader damaged files until something breaks."""

from __future__ import annotations

import faulthandler
import signal
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from random import Random
from types import FrameType
from typing import TYPE_CHECKING

from .mutations import damaged

if TYPE_CHECKING:
    from .readers import Reader

SLOW = 5.0
"""Seconds of CPU time from which on a case is told."""

TOO_SLOW = 30
"""Seconds of CPU time after which a case is broken off."""

LONGEST = 200_000
"""Bytes of a case: what is longer only takes longer."""

STUCK = 300
"""Seconds of the wall clock after which the process ends, where nothing else helps."""


class EndlessError(BaseException):
    """A case that takes too long."""


def case(reader: Reader, number: int, seed: object) -> bytes:
    """The damaged file of that number: the same each time."""
    draw = Random(f"{seed} {number}")
    return damaged(draw.choice(reader.samples()), draw, reader.form)[:LONGEST]


def hunt(name: str, reader: Reader, cases: range, seed: int) -> int:
    """Tell every kind of crash that damaged files of these numbers lead to; how many there are."""
    crashes: Counter[str] = Counter()
    reader.read(reader.samples()[0])
    begin = time.process_time()
    for number in cases:
        data = case(reader, number, seed)
        before = time.process_time()
        try:
            with _limited():
                reader.read(data)
        except (Exception, EndlessError) as why:
            place = traceback.extract_tb(why.__traceback__)[-1]
            where = f"{type(why).__name__} at {place.filename}:{place.lineno}"
            if where not in crashes:
                _tell(f"{name}, case {number}: {where}: {str(why)[:200]}", data)
            crashes[where] += 1
        if time.process_time() - before > SLOW:
            _tell(f"{name}, case {number}: {time.process_time() - before:.1f} s", data)
    seconds = time.process_time() - begin
    asked = f"{len(cases):,} cases from {cases.start:,} on"
    print(f"{name}: {asked}, {seconds:.0f} s of CPU time, {crashes.total()} crashes")
    for where, count in crashes.most_common():
        print(f"  {count} × {where}")
    return len(crashes)


def _tell(what: str, data: bytes) -> None:
    print(f"{what}\n  {data[:1500]!r}{'…' if len(data) > 1500 else ''}", flush=True)


@contextmanager
def _limited() -> Iterator[None]:
    """Break off what needs too much time in this context; warnings are errors, too."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise EndlessError(f"more than {TOO_SLOW} s")

    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, TOO_SLOW)
    faulthandler.dump_traceback_later(STUCK, exit=True)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", ResourceWarning)
            yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        faulthandler.cancel_dump_traceback_later()
