"""Design of a study: distributions, rows, and the study file."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, field, replace
from functools import cached_property
from pathlib import Path
from statistics import NormalDist
from typing import Annotated, Any, Protocol

from pydantic import Field, model_validator

from floorplan import InputError, Problem, UserError
from floorplan.files.dataclass import dataclass
from floorplan.files.documents import Document, parse_yaml, read_yaml
from floorplan.files.fields import Flag, Number, Pair, Positive, whole
from floorplan.files.models import Strictly
from floorplan.files.problems import field_name, suggestion
from floorplan.files.reading import is_there

from ..core.entries import is_number
from ..core.scenario import LARGEST_SEED
from ..trials.checks import faults, name_fault
from ..trials.expectations import summary_fields
from ..trials.trial import Trial
from .repeats import UntilKeys
from .variables import Value, Variable, reordered, variable, without_controllers

SIGMAS = 3.0
"""Standard deviations from its mean at which a normal distribution ends, if not given."""

DECIMALS = 6
"""Decimals of drawn numbers, so that they remain readable."""

_TINY = 1e-15
"""Smallest share of which the inverse of a normal distribution is computed."""


def derived_seed(*parts: object) -> int:
    """Return a seed of 63 bits that depends only on `parts` (numbers, texts and lists)."""
    digest = hashlib.sha256(json.dumps(parts).encode()).digest()
    return int.from_bytes(digest[:8], "big") >> 1


class Distribution(Protocol):
    """Source of random values."""

    @property
    def extremes(self) -> Sequence[Value]:
        """Values that must be valid if all values that can be drawn are to be valid."""
        ...

    def draw(self, seed: int, trial: Trial) -> Value:
        """Return the value drawn with `seed` for `trial`."""
        ...


@dataclass(frozen=True)
class Uniform:
    """Numbers from `low` to `high` with equal probability. Lists are drawn element by element."""

    low: float | tuple[float, ...]
    high: float | tuple[float, ...]

    def __str__(self) -> str:
        return f"uniform from {self.low} to {self.high}"

    @property
    def extremes(self) -> Sequence[Value]:
        """See `Distribution`."""
        return (self.low, self.high)

    def draw(self, seed: int, trial: Trial) -> Value:
        """See `Distribution`."""
        rng = random.Random(seed)
        if isinstance(self.low, tuple) and isinstance(self.high, tuple):
            ends = zip(self.low, self.high, strict=True)
            return tuple(_between(low, high, rng.random()) for low, high in ends)
        assert not isinstance(self.low, tuple) and not isinstance(self.high, tuple)
        return _between(self.low, self.high, rng.random())


@dataclass(frozen=True)
class Normal:
    """Normal distribution with `mean` and standard deviation `sd`, from `low` to `high`."""

    mean: float
    sd: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"normal, {self.mean:g} ± {self.sd:g}, from {self.low:g} to {self.high:g}"

    @property
    def extremes(self) -> Sequence[Value]:
        """See `Distribution`."""
        return (self.low, self.high)

    def draw(self, seed: int, trial: Trial) -> Value:
        """See `Distribution`."""
        # Inversion of the truncated distribution needs a single draw.
        return self.quantile(random.Random(seed).random())

    def quantile(self, share: float) -> float:
        """Return the number below which a `share` of the truncated distribution lies."""
        normal = NormalDist(self.mean, self.sd)
        least, most = normal.cdf(self.low), normal.cdf(self.high)
        tail = min(max(least + share * (most - least), _TINY), 1 - _TINY)
        return min(max(round(normal.inv_cdf(tail), DECIMALS), self.low), self.high)


@dataclass(frozen=True)
class Choice:
    """One of several values with equal probability."""

    values: tuple[Value, ...]

    def __str__(self) -> str:
        return f"one of {', '.join(map(str, self.values))}"

    @property
    def extremes(self) -> Sequence[Value]:
        """See `Distribution`."""
        return self.values

    def draw(self, seed: int, trial: Trial) -> Value:
        """See `Distribution`."""
        # Not `choice`, because only `random` draws the same in every version of Python.
        return self.values[int(random.Random(seed).random() * len(self.values))]


@dataclass(frozen=True)
class Shuffled:
    """Jobs of the trial in random order. Submissions stay behind the jobs that they need."""

    def __str__(self) -> str:
        return "shuffled"

    @property
    def extremes(self) -> Sequence[Value]:
        """See `Distribution`."""
        return ("given",)

    def draw(self, seed: int, trial: Trial) -> Value:
        """See `Distribution`."""
        rng = random.Random(seed)
        return reordered(
            trial.gantry.jobs, lambda stretch: sorted(stretch, key=lambda _: rng.random())
        )


def _between(low: float, high: float, share: float) -> float:
    return min(max(round(low + share * (high - low), DECIMALS), low), high)


class StudyError(InputError):
    """Error of a study that cannot be run."""


@dataclass(frozen=True)
class Row:
    """One run of a study: its number, its varied values, and its trial."""

    number: int
    parameters: dict[str, Value]
    trial: Trial


@dataclass(frozen=True)
class Combination:
    """One trial with one value of every variable of the grid."""

    trial: Trial
    values: tuple[Value, ...]


@dataclass(frozen=True)
class Design:
    """Combinations of trials and grid values, each `repeat` times, with random values.

    The seed of a row follows from the study's seed and the row's own parameters without
    controllers. The order of rows and other variables have no influence. Random values depend on
    the repetition only. Therefore all combinations, and all controllers, have the same draws and
    can be compared pair by pair (common random numbers). With `metrics`, rows contain the metrics
    of social navigation. Paths of files in `grid` and `random` are relative to `folder`. `search`
    contains the keys of a worst-case search.
    """

    name: str
    trials: tuple[Trial, ...]
    _: KW_ONLY
    grid: Mapping[Variable, tuple[Value, ...]] = field(default_factory=dict)
    random: Mapping[Variable, Distribution] = field(default_factory=dict)
    repeat: int = 1
    seed: int = 0
    metrics: bool = False
    folder: Path = Path()
    search: SearchKeys | None = None
    until: UntilKeys | None = None

    def __len__(self) -> int:
        """Return the number of rows. Raises `OverflowError` if it exceeds 63 bits (see `size`)."""
        return self.size

    @property
    def size(self) -> int:
        """Number of rows."""
        combinations = math.prod(len(values) for values in self.grid.values())
        return len(self.trials) * self.repeat * combinations

    def rows(self, first: int = 0) -> Iterator[Row]:
        """Return an iterator of the rows: each combination once, then each again per repetition.

        Parameters
        ----------
        first : int, optional
            Number of the first row.
        """
        return (self.row(number) for number in range(first, len(self)))

    def row(self, number: int) -> Row:
        """Return a row.

        Parameters
        ----------
        number : int
            Number of the row.

        Raises
        ------
        ValueError
            If there is no such row.
        """
        if not 0 <= number < len(self):
            raise UserError(f"{self.name} has rows 0 to {len(self) - 1}, but no row {number}")
        repetition, index = divmod(number, len(self.combinations))
        combination = self.combinations[index]
        chosen: dict[str, Value] = {"trial": combination.trial.name}
        decisive: list[tuple[str, Value]] = [("trial", self._compared[combination.trial.name])]
        chosen |= {what.name: one for what, one in zip(self.grid, combination.values, strict=True)}
        decisive += [(what.name, chosen[what.name]) for what in self.grid if not what.is_controller]
        seed = derived_seed("run", self.seed, decisive, repetition)
        trial = replace(combination.trial, seed=seed)
        drawn: dict[str, Value] = {}
        for what, distribution in self.random.items():
            draw = derived_seed("draw", self.seed, what.name, repetition)
            value = drawn[what.name] = distribution.draw(draw, trial)
            trial = self._put(trial, what, value)
        return Row(number, {**chosen, **drawn, "repetition": repetition, "seed": seed}, trial)

    @cached_property
    def _compared(self) -> dict[str, str]:
        """For each trial by name, the first trial that differs from it only in controllers."""
        compared: dict[str, str] = {}
        first: list[Trial] = []
        for trial in self.trials:
            plain = without_controllers(replace(trial, name=""))
            same = next((k for k, one in enumerate(first) if one == plain), len(first))
            first.append(plain)
            compared[trial.name] = self.trials[same].name
        return compared

    @cached_property
    def combinations(self) -> tuple[Combination, ...]:
        """Combinations of trials and values of the grid."""
        return tuple(
            Combination(self._with(trial, values), values)
            for trial in self.trials
            for values in itertools.product(*self.grid.values())
        )

    def _with(self, trial: Trial, values: tuple[Value, ...]) -> Trial:
        for what, value in zip(self.grid, values, strict=True):
            trial = self._put(trial, what, value)
        return trial

    def _put(self, trial: Trial, what: Variable, value: Value) -> Trial:
        return what.put(trial, value, self.folder, (*self.grid, *self.random))


MOST_ROWS = 1_000_000
"""Maximum number of rows of a study."""


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


class SearchKeys(Strictly):
    """The keys of a search in a study file."""

    minimise: str | None = None
    slack: str | None = None
    below: Number = 0.0
    sampler: str = "tpe"
    evaluations: Annotated[int, whole(1, MOST_ROWS)] = 200
    batch: Annotated[int, whole(1)] = 8
    random_share: Annotated[float, Field(ge=0.0, le=1.0)] = 0.25
    cases: Annotated[int, whole(0)] = 5


class _StudyKeys(Strictly):
    name: str | None = None
    trials: Annotated[list[str], Field(min_length=1)]
    grid: dict[str, list[Any]] = {}
    random: dict[str, _Draw] = {}
    repeat: Annotated[int, whole(1)] = 1
    seed: Annotated[int, whole(0, LARGEST_SEED)] = 0
    metrics: Flag = False
    own_code: Flag = True
    search: SearchKeys | None = None
    until: UntilKeys | None = None


@dataclass(frozen=True, repr=False)
class Study(Design):
    """Trials with variations of their values.

    Parameters
    ----------
    name : str
        Name of the study.
    trials : tuple of Trial
        Trials to vary.
    grid : mapping, optional
        Values of each variable. Each combination is simulated.
    random : mapping, optional
        Distribution of each random variable.
    repeat : int, optional
        Number of repetitions of each combination.
    seed : int, optional
        Random seed from which those of the rows are derived.
    metrics : bool, optional
        Whether the results include the metrics of social navigation.
    folder : Path, optional
        Folder of the study.
    """

    def __repr__(self) -> str:
        trials = ", ".join(repr(trial.name) for trial in self.trials)
        return f"<{type(self).__name__} {self.name!r}: {len(self)} rows of {trials}>"

    @classmethod
    def load(cls, path: str | Path, *, own_code: bool = True) -> Study:
        """Return the study in a YAML file.

        Parameters
        ----------
        path : str or Path
            File.
        own_code : bool, optional
            Whether the trials may use custom Python code.

        Raises
        ------
        StudyError
            If the file cannot be read or contains errors. All errors are reported together.
        """
        path = Path(path)
        return _build(cls, read_yaml(path, StudyError), path.parent, own_code)

    @classmethod
    def parse(
        cls,
        text: str,
        *,
        file: str = "<text>",
        folder: str | Path = ".",
        own_code: bool = True,
    ) -> Study:
        """Return the study in a text.

        Parameters
        ----------
        text : str
            YAML.
        file : str, optional
            Name of the text in messages.
        folder : str or Path, optional
            Folder of the files that it names.
        own_code : bool, optional
            Whether the trials may use custom Python code.

        Raises
        ------
        StudyError
            If the text contains errors. All errors are reported together.
        """
        return _build(cls, parse_yaml(text, file, StudyError), Path(folder), own_code)


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
    if schema.until is not None:
        reader.until(schema.until, trials)
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
        search=schema.search,
        until=schema.until,
    )
    if study.size > MOST_ROWS:
        message = f"the rows are more than the {MOST_ROWS:,} that a study may have"
        message += " (trials × grid × repeat)"
        raise StudyError(document.file, [Problem(message)])
    return study


class _Reader:
    """Reads the parts of a study and collects their problems."""

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
                file = path if path.suffix or is_there(path) else source
                trial = Trial.load(file, own_code=self._own_code)
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
        for name, written in schema.items():
            values = tuple(_value(one) for one in written)
            what = self._variable(name, "grid")
            if not values:
                self._problem("has no values", "grid", name)
            if what is None:
                continue
            for k, value in enumerate(values):
                if value in values[:k]:
                    self._problem(f"{written[k]!r} stands twice", "grid", name, k)
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
            for one in trials:
                self._try(what, distribution.draw(0, one), (one,), "random", name)
            drawn[what] = distribution
        return drawn

    def until(self, until: UntilKeys, trials: tuple[Trial, ...]) -> None:
        """Report a problem if runs of the trials lack the figure to stop by."""
        for trial in trials:
            figures = summary_fields(trial)
            paths = {key for key, one in figures.items() if ".".join(one.path).startswith(key)}
            if until.of not in paths or figures[until.of].figure.form == "flag":
                hint = suggestion(until.of, sorted(paths))
                self._problem(f"a run has no such figure; {hint}", "until", "of")

    def _variable(self, name: str, section: str) -> Variable | None:
        try:
            return variable(name)
        except UserError as why:
            self._problem(str(why), section, name)
            return None

    def _try(
        self, what: Variable, value: Value, trials: tuple[Trial, ...], *place: str | int
    ) -> None:
        """Report a problem if one of the trials cannot have this value."""
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
    kinds = [one for one in (entry.uniform, entry.normal, entry.choice) if one is not None]
    if len(kinds) != 1 or (entry.within is not None and entry.normal is None):
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
    """Return a value in the form that variables accept. Variables check it."""
    return tuple(value) if isinstance(value, list) else value
