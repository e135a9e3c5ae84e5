"""Repeats of a test with several seeds. Identical ones are reported, and count as one."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from ..record.figures import FIGURES
from ..runs.run import Run
from .variations import FIXTURE, Variation

_LEFT_OUT = frozenset(path for path, figure in FIGURES.items() if not figure.column)
"""Figures that depend on the machine and the time of a run."""


def repeat_of(item: Any, runs: Sequence[Run]) -> tuple[str, str]:
    """Return the name of a test without its seed, and a digest of the figures of its runs."""
    variation: Variation = item.callspec.params[FIXTURE]
    test, _, parameters = item.nodeid.removesuffix("]").partition("[")
    others = parameters.replace(variation.name, variation.without_seed, 1).strip("-")
    summaries = [run.summary.items() for run in runs]
    figures = [[item for item in items if item[0] not in _LEFT_OUT] for items in summaries]
    name = f"{test}[{others}]" if others else test
    return name, hashlib.sha256(repr(figures).encode()).hexdigest()


def identical_repeats(repeats: Iterable[Any]) -> Iterator[str]:
    """Yield a sentence for each test whose runs with runs seeds are identical.

    `repeats` contains the result of `repeat_of` for each seed.
    """
    digests: dict[str, list[str]] = {}
    for test, digest in repeats:
        digests.setdefault(test, []).append(digest)
    for test, runs in digests.items():
        if len(runs) > 1 and len({*runs}) == 1:
            yield (
                f"{test}: the runs with {len(runs)} seeds are identical, because nothing is drawn"
                " in them. They count as one."
            )
