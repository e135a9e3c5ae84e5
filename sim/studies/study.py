"""Studies: designs that are read from files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, model_validator

import floorplan
from floorplan import (
    Document,
    Flag,
    Number,
    Pair,
    Positive,
    Problem,
    Strictly,
    UserError,
    field_name,
    whole,
)

from ..core.numbers import is_number
from ..trials.checks import LARGEST_SEED, faults, name_fault
from ..trials.trial import Trial
from .definition import Design, StudyError
from .draws import SIGMAS, Choice, Distribution, Normal, Shuffled, Uniform
from .variables import Value, Variable, variable

MOST_ROWS = 1_000_000
"""A study of more rows than this is refused: it is more likely a slip."""


class _Draw(Strictly):
    """Distribution of a variable, or only a word."""

    uniform: tuple[Any, Any] | None = None
    normal: tuple[Number, Positive] | None = None
    within: Pair | None = None
    choice: Annotated[list[Any], Field(min_length=1)] | None = None
    word: str | None = None

    @model_validator(mode="before")
    @classmethod
    def _only_a_word(cls, value: object) -> object:
        if isinstance(value, str):
            return {"word": value}
        if isinstance(value, Mapping) and "word" in value:
            raise UserError("unknown key 'word'")
        return value


class _StudyKeys(Strictly):
    name: str | None = None
    trials: Annotated[list[str], Field(min_length=1)]
    grid: dict[str, list[Any]] = {}
    random: dict[str, _Draw] = {}
    repeat: Annotated[int, whole(1)] = 1
    seed: Annotated[int, whole(0, LARGEST_SEED)] = 0
    metrics: Flag = False
    own_code: Flag = True


@dataclass(frozen=True, repr=False)
class Study(Design):
    """Trials in variations, as a `Design` has them; it can be loaded."""

    def __repr__(self) -> str:
        trials = ", ".join(repr(trial.name) for trial in self.trials)
        return f"<{type(self).__name__} {self.name!r}: {len(self)} rows of {trials}>"

    @classmethod
    def load(cls, path: str | Path, *, own_code: bool = True) -> Study:
        """The study in the YAML file at `path`.

        Without `own_code` its trials may name no Python of the user's own, as of `Trial.load`.
        `StudyError` with everything that is wrong, each with its place.
        """
        path = Path(path)
        return _build(cls, floorplan.read_yaml(path, StudyError), path.parent, own_code)

    @classmethod
    def parse(
        cls,
        text: str,
        *,
        file: str = "<text>",
        folder: str | Path = ".",
        own_code: bool = True,
    ) -> Study:
        """The study in `text`, as if it stood in `folder`; errors call it `file`.

        `own_code` is as of `load`.
        """
        return _build(cls, floorplan.parse_yaml(text, file, StudyError), Path(folder), own_code)


def _build(form: type[Study], document: Document, folder: Path, own_code: bool) -> Study:
    keys = document.data if isinstance(document.data, dict) else {}
    if "floorplan" in keys and "trials" not in keys:
        message = "is a trial, not a study; a study names it among its `trials`"
        raise StudyError(document.file, [Problem(message)])
    schema = document.checked(_StudyKeys, StudyError)
    reader = _Reader(document, folder, own_code and schema.own_code)
    trials = reader.trials(schema.trials)
    grid = reader.grid(schema.grid, trials)
    drawn = reader.random(schema.random, trials, schema.grid)
    name = schema.name or Path(document.file).name.split(".")[0]
    if fault := name_fault(name):
        reader.problems.append(document.problem(fault, "name"))
    if reader.problems:
        raise StudyError(document.file, reader.problems)
    study = form(
        name=name,
        trials=trials,
        grid=grid,
        random=drawn,
        repeat=schema.repeat,
        seed=schema.seed,
        metrics=schema.metrics,
        folder=folder,
    )
    if study.size > MOST_ROWS:
        message = f"the rows are more than the {MOST_ROWS:,} that a study may have"
        message += " (trials × grid × repeat)"
        raise StudyError(document.file, [Problem(message)])
    return study


class _Reader:
    """Reads the parts of a study, and gathers what is wrong with them."""

    def __init__(self, document: Document, folder: Path, own_code: bool) -> None:
        self.problems: list[Problem] = []
        self._document = document
        self._folder = folder
        self._own_code = own_code

    def trials(self, sources: list[str]) -> tuple[Trial, ...]:
        trials: list[Trial] = []
        seen: set[str] = set()
        for k, source in enumerate(sources):
            if source in seen:
                self._problem(f"{source!r} stands twice", "trials", k)
                continue
            seen.add(source)
            try:
                path = self._folder / source
                found = path if path.suffix or floorplan.is_there(path) else source
                trial = Trial.load(found, own_code=self._own_code)
            except (UserError, OSError) as why:
                self._problem(str(why), "trials", k)
                continue
            if trial.name in [other.name for other in trials]:
                message = f"another trial is called {trial.name!r} already; give one another name"
                self._problem(message, "trials", k)
            trials.append(trial)
        return tuple(trials)

    def grid(
        self, schema: dict[str, list[Any]], trials: tuple[Trial, ...]
    ) -> dict[Variable, tuple[Value, ...]]:
        grid: dict[Variable, tuple[Value, ...]] = {}
        for name, given in schema.items():
            values = tuple(_value(one) for one in given)
            what = self._variable(name, "grid")
            if not values:
                self._problem("has no values", "grid", name)
            if what is None:
                continue
            for k, value in enumerate(values):
                if value in values[:k]:
                    self._problem(f"{given[k]!r} stands twice", "grid", name, k)
                self._try(what, value, trials, "grid", name, k)
            grid[what] = values
        return grid

    def random(
        self, schema: dict[str, _Draw], trials: tuple[Trial, ...], grid: dict[str, Any]
    ) -> dict[Variable, Distribution]:
        drawn: dict[Variable, Distribution] = {}
        for name, entry in schema.items():
            what = self._variable(name, "random")
            if name in grid:
                self._problem("stands in the grid as well", "random", name)
            try:
                distribution = _distribution(name, entry)
            except UserError as why:
                self._problem(str(why), "random", name)
                continue
            if what is None:
                continue
            for value in distribution.extremes:
                self._try(what, value, trials, "random", name)
            drawn[what] = distribution
        return drawn

    def _variable(self, name: str, section: str) -> Variable | None:
        try:
            return variable(name)
        except UserError as why:
            self._problem(str(why), section, name)
            return None

    def _try(
        self, what: Variable, value: Value, trials: tuple[Trial, ...], *place: str | int
    ) -> None:
        """Say it if one of the trials can't have this value."""
        for trial in trials:
            try:
                changed = what.put(trial, value, self._folder)
                for fault, field in faults(changed):
                    raise UserError(f"{field_name(field)}: {fault}")
            except (UserError, OSError) as why:
                where = f"the trial {trial.name!r} can't have it: " if len(trials) > 1 else ""
                self._problem(f"{where}{why}", *place)
                return

    def _problem(self, message: str, *place: str | int) -> None:
        problem = self._document.problem(message, *place)
        if problem not in self.problems:
            self.problems.append(problem)


def _distribution(name: str, entry: _Draw) -> Distribution:
    if entry.word == "shuffled" and name == "job_order":
        return Shuffled()
    if entry.word is not None:
        usual = "shuffled" if name == "job_order" else "uniform, normal or choice with values"
        raise UserError(f"expected {usual}, found {entry.word!r}")
    given = [one for one in (entry.uniform, entry.normal, entry.choice) if one is not None]
    if len(given) != 1 or (entry.within is not None and entry.normal is None):
        raise UserError("give one of uniform, choice, or normal (with within, if you like)")
    if entry.uniform is not None:
        return _uniform(*entry.uniform)
    if entry.choice is not None:
        return Choice(tuple(_value(one) for one in entry.choice))
    assert entry.normal is not None  # one of the three is given
    mean, sd = entry.normal
    low, high = entry.within or (mean - SIGMAS * sd, mean + SIGMAS * sd)
    if not low <= mean <= high or low == high:
        raise UserError(f"within has to be [low, high] around the mean {mean:g}")
    return Normal(mean, sd, low, high)


def _uniform(low: Any, high: Any) -> Uniform:
    lows, highs = (end if isinstance(end, list) else [end] for end in (low, high))
    alike = isinstance(low, list) == isinstance(high, list) and len(lows) == len(highs)
    if not (
        alike
        and all(map(is_number, [*lows, *highs]))
        and all(a <= b for a, b in zip(lows, highs, strict=True))
    ):
        raise UserError("uniform has to be [low, high]: two numbers, or two lists of numbers")
    return Uniform(_value(low), _value(high))


def _value(value: Any) -> Any:
    """A value as variables take it; whether it makes sense, they say themselves."""
    return tuple(value) if isinstance(value, list) else value
