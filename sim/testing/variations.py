"""Markers that vary the trial of a test: their values and changes."""

from __future__ import annotations

import fnmatch
import itertools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import bdi
from floorplan import UserError
from floorplan.files.dataclass import dataclass

from ..core.custom_code import CodeFolder
from ..core.rules import RULE_SETS, RuleSet
from ..machines.gantry.controllers import CONTROLLERS, controller_source
from ..machines.kinds import with_controller
from ..people.programs import EXTERNAL, find_program
from ..trials.rules_file import find_rules
from ..trials.trial import Trial, builtin_trials

FIXTURE = "_floorwalker_variation"
"""Name of the fixture with the `Variation`."""


Change = Callable[[Trial], Trial]


@dataclass(frozen=True)
class Variation:
    """Trial of a test according to its markers, with changes in order.

    `trial` is None without a marker for it. `name` is part of the name of the test, and
    `without_seed` is the same without the seed.
    """

    trial: Trial | None
    changes: tuple[Change, ...]
    name: str
    without_seed: str

    def of(self, trial: Trial) -> Trial:
        """Return the varied trial."""
        for change in self.changes:
            trial = change(trial)
        return trial


def vary(metafunc: pytest.Metafunc) -> None:
    """Parametrise a test with every combination of the values of its markers."""
    choices: dict[str, list[tuple[str, Trial | Change]]] = {}
    own_code = not metafunc.config.getoption("--no-own-code")
    place = CodeFolder(metafunc.definition.path.parent, own_code)
    for marker, option in _OPTIONS.items():
        mark = metafunc.definition.get_closest_marker(marker)
        if mark is not None:
            choices[marker] = _choices(marker, mark, option, place)
    if FIXTURE not in metafunc.fixturenames:
        pytest.fail(
            f"{metafunc.definition.nodeid} is to be run with several trials, but takes none;"
            " let it take trial or run_trial",
            pytrace=False,
        )
    combinations = list(itertools.product(*choices.values()))
    metafunc.parametrize(
        FIXTURE,
        [_variation(dict(zip(choices, combined, strict=True))) for combined in combinations],
        indirect=True,
        ids=lambda variation: variation.name,
    )


def find_trial(source: str | Path, folder: Path, *, own_code: bool) -> Trial:
    """Return a built-in trial, or the one in a file relative to `folder`.

    `own_code` is as of `Trial.load`.
    """
    place = source if str(source) in builtin_trials() else folder / source
    return Trial.load(place, own_code=own_code)


@dataclass(frozen=True)
class _Option:
    """Values of a marker, given by name, pattern or "all", and the reader of a value.

    `read` raises the library's error for an unknown name.
    """

    every: Iterable[str]
    read: Callable[[Any, CodeFolder], Trial | Change]


def _variation(combined: Mapping[str, tuple[str, Trial | Change]]) -> Variation:
    """Return the variation of a combination of names and objects by marker."""
    trial, changes = None, []
    for _, one in combined.values():
        if isinstance(one, Trial):
            trial = one
        else:
            changes.append(one)
    name = "-".join(name for name, _ in combined.values())
    others = "-".join(name for marker, (name, _) in combined.items() if marker != "seeds")
    return Variation(trial, tuple(changes), name, others)


def _choices(
    marker: str, mark: pytest.Mark, option: _Option, place: CodeFolder
) -> list[tuple[str, Trial | Change]]:
    """Return the values of a marker: names and objects."""
    values: list[Any] = []
    for value in mark.args:
        if value == "all" and option.every:
            values += option.every
        elif isinstance(value, str) and (matching := fnmatch.filter(option.every, value)):
            values += matching
        elif isinstance(value, Iterable) and not isinstance(value, str):
            values += value
        else:
            values.append(value)
    if not values or mark.kwargs:
        pytest.fail(f"@pytest.mark.{marker} needs one value or more", pytrace=False)
    choices, faults = [], []
    for value in values:
        try:
            choices.append((_name(value), option.read(value, place)))
        except (UserError, OSError) as why:
            faults.append(f"@pytest.mark.{marker}: {why}")
    if faults:
        pytest.fail("\n".join(faults), pytrace=False)
    return choices


def _name(value: Any) -> str:
    """Return the name of a value in the name of a test: a file without its suffix."""
    if isinstance(value, Trial | RuleSet):
        return value.name
    text = str(getattr(value, "__name__", value))
    return text if ":" in text else Path(text).name.split(".")[0]


def _text(value: Any) -> str:
    if not isinstance(value, str | Path):
        raise UserError(f"expected a name or a file, found {value!r}")
    return str(value)


def _trial(value: Any, place: CodeFolder) -> Trial:
    if isinstance(value, Trial):
        return value
    return find_trial(_text(value), place.path, own_code=place.allowed)


def _personality(value: Any, place: CodeFolder) -> Change:
    name = _text(value)
    path = place.path / name
    chosen = str(path) if path.suffix == ".asl" or path.is_dir() else name
    if chosen != EXTERNAL:
        find_program(chosen, place.path)
    return lambda trial: trial.with_personality(chosen)


def _controller(value: Any, place: CodeFolder) -> Change:
    controller = value if callable(value) else _text(value)
    controller_source(controller, place)

    def change(trial: Trial) -> Trial:
        # Named files are relative to the test, as those of trials are relative to the trial.
        home = trial.folder if callable(controller) or controller in CONTROLLERS else place.path
        return with_controller(replace(trial, folder=home), controller)

    return change


def _rules(value: Any, place: CodeFolder) -> Change:
    rules = value if isinstance(value, RuleSet) else find_rules(_text(value), place)
    return lambda trial: replace(trial, rules=rules)


def _seed(seed: Any, _: CodeFolder) -> Change:
    if not isinstance(seed, int) or isinstance(seed, bool) or seed < 0:
        raise UserError(f"expected whole numbers of at least 0, found {seed!r}")
    return lambda trial: replace(trial, seed=seed)


_OPTIONS = {
    "trials": _Option(builtin_trials(), _trial),
    "personalities": _Option(sorted(bdi.programs()), _personality),
    "controllers": _Option(sorted({*CONTROLLERS} - {EXTERNAL}), _controller),
    "rule_sets": _Option(sorted(RULE_SETS), _rules),
    "seeds": _Option((), _seed),
}
