"""Markers that vary the trial of a test: which values they give, and what these do to a trial."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

import bdi

from ..controllers import CONTROLLERS, find_controller
from ..rules import RULE_SETS
from ..trials.programs import EXTERNAL, load_program
from ..trials.rules_file import find_rules
from ..trials.trial import Trial

FIXTURE = "_floorwalker_variation"
"""The fixture that gets a `Variation`."""


@dataclass(frozen=True)
class Variation:
    """What a test's markers make of its trial: changes, to be made one after another."""

    changes: tuple[Callable[[Trial], Trial], ...]

    def of(self, trial: Trial) -> Trial:
        """The trial as it is varied."""
        for change in self.changes:
            trial = change(trial)
        return trial


def vary(metafunc: pytest.Metafunc) -> None:
    """Run a test once for every combination of what its markers give."""
    choices = []
    for marker, option in _OPTIONS.items():
        mark = metafunc.definition.get_closest_marker(marker)
        if mark is not None:
            choices.append(_choices(marker, mark, option, metafunc.definition.path.parent))
    if FIXTURE not in metafunc.fixturenames:
        pytest.fail(
            f"{metafunc.definition.nodeid} is to be run with several trials, but takes none;"
            " let it take trial or run_trial",
            pytrace=False,
        )
    combinations = list(itertools.product(*choices))
    metafunc.parametrize(
        FIXTURE,
        [Variation(tuple(change for _, change in combined)) for combined in combinations],
        indirect=True,
        ids=["-".join(name for name, _ in combined) for combined in combinations],
    )


@dataclass(frozen=True)
class _Option:
    """What a marker takes: all there are by the word "all", and what a value makes of a trial.

    `change` raises what the library does if there is nothing of that name.
    """

    every: Iterable[str]
    change: Callable[[Any, Path], Callable[[Trial], Trial]]


def _choices(
    marker: str, mark: pytest.Mark, option: _Option, folder: Path
) -> list[tuple[str, Callable[[Trial], Trial]]]:
    """The name and the change of every value that a marker gives."""
    values: list[Any] = []
    for value in mark.args:
        if value == "all" and option.every:
            values += option.every
        elif isinstance(value, Iterable) and not isinstance(value, str):
            values += value
        else:
            values.append(value)
    if not values or mark.kwargs:
        pytest.fail(f"@pytest.mark.{marker} needs one value or more", pytrace=False)
    found, fault = [], ""
    for value in values:
        try:
            found.append((_name(value), option.change(value, folder)))
        except (ValueError, OSError) as why:
            fault = f"@pytest.mark.{marker}: {why}"
    if fault:
        pytest.fail(fault, pytrace=False)
    return found


def _name(value: Any) -> str:
    return value.__name__ if callable(value) else Path(str(value)).name.split(".")[0]


def _trial(source: str, folder: Path) -> Callable[[Trial], Trial]:
    path = folder / source
    loaded = Trial.load(path if path.exists() else source)
    return lambda _: loaded


def _personality(name: str, folder: Path) -> Callable[[Trial], Trial]:
    path = folder / name
    chosen = str(path) if path.suffix == ".asl" else name
    load_program(chosen, folder)
    return lambda trial: trial.with_personality(chosen)


def _controller(wanted: Any, folder: Path) -> Callable[[Trial], Trial]:
    name = f"{wanted.__module__}:{wanted.__qualname__}" if callable(wanted) else str(wanted)
    find_controller(name, folder)

    def change(trial: Trial) -> Trial:
        # A controller of one's own is looked up beside the test, as trials look beside themselves.
        home = trial.folder if name in CONTROLLERS else folder
        return replace(trial, folder=home, gantry=replace(trial.gantry, controller=name))

    return change


def _rules(name: str, folder: Path) -> Callable[[Trial], Trial]:
    rules = find_rules(name, folder)
    return lambda trial: replace(trial, rules=rules)


def _seed(seed: Any, _: Path) -> Callable[[Trial], Trial]:
    if not isinstance(seed, int) or isinstance(seed, bool) or seed < 0:
        raise ValueError(f"expected whole numbers of at least 0, found {seed!r}")
    return lambda trial: replace(trial, seed=seed)


_OPTIONS = {
    "trials": _Option((), _trial),
    "personalities": _Option(sorted(bdi.programs()), _personality),
    "controllers": _Option(sorted({*CONTROLLERS} - {EXTERNAL}), _controller),
    "rule_sets": _Option(sorted(RULE_SETS), _rules),
    "seeds": _Option((), _seed),
}
