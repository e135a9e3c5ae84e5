"""Built-in study that compares gantry controllers on standard scenes with random values."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from floorplan import UserError
from floorplan.files.dataclass import dataclass

from ..core.wording import figure
from ..machines.gantry.controllers import CONTROLLERS, controller_source
from ..people.programs import EXTERNAL
from ..trials.trial import Trial
from ..views.report_page import write_report_page
from .comparison import Floats, Measure, Spread, StudyResults, spread
from .design import Choice, Shuffled, Study, Uniform
from .folder import save_trial
from .variables import variable

NAME = "scoreboard"
"""Name of the study."""

SCENES = ("one_person", "two_people", "crowd")
"""Names of its trials."""

FLIPS = 10_000
"""Number of random signs of the differences for a test."""

MEASURES = (
    Measure("Least margin, moving", "least_margin_moving.value", "m", worst=1),
    Measure("Jobs done", "jobs_done", worst=1),
    Measure("Penalties", "penalties", worst=-1),
    Measure("Approaches", "approaches.count", worst=-1),
    Measure("People's visits lost", "counterfactual.visits", worst=1),
)
"""Figures of the scoreboard: more is better where `worst` is 1."""


@dataclass(frozen=True)
class Score:
    """Score of a controller: the spread of each measure, and the row with the least margin."""

    controller: str
    spreads: dict[Measure, Spread | None]
    least_margin: float | None
    worst_row: int | None


@dataclass(frozen=True)
class PairedTest:
    """Paired test of two controllers by one measure.

    `difference` is the mean of the first minus the second over trials with the same draws, with the
    95 % interval from `low` to `high`. `p` is the probability of a difference at least as large
    between equal controllers.
    """

    one: str
    other: str
    measure: Measure
    count: int
    difference: float
    low: float
    high: float
    p: float


def scoreboard(
    controllers: Sequence[str] = (), *, repeat: int = 20, seed: int = 0, folder: str | Path = "."
) -> Study:
    """Return the study that compares gantry controllers.

    Parameters
    ----------
    controllers : sequence of str, optional
        Built-in controllers, or `package.module:name` in `folder`. Default: all built-in ones.
    repeat : int, optional
        Number of random trials of each scene.
    seed : int, optional
        Seed of the study.
    folder : path, optional
        Folder of custom controllers.

    Returns
    -------
    Study
        The study. All controllers meet the same draws.

    Raises
    ------
    UserError
        If a controller does not exist or is given twice.
    """
    names = (*controllers,) or tuple(sorted({*CONTROLLERS} - {EXTERNAL}))
    if len({*names}) < len(names):
        raise UserError(f"each controller can be given once, not {', '.join(names)}")
    place = Path(folder)
    trials = []
    for scene in SCENES:
        file = Path(__file__).parents[1] / "data" / NAME / f"{scene}.yaml"
        trials.append(replace(Trial.load(file), folder=place))
    for name in names:
        controller_source(name, trials[0].code_folder)
    return Study(
        name=NAME,
        trials=tuple(trials),
        grid={variable("controller"): names},
        random={
            variable("personality"): Choice(("helpful", "indifferent", "antagonistic")),
            variable("max_speed"): Uniform(0.8, 1.4),
            variable("gantry_at"): Uniform((-12.0, -3.0, 0.0), (-3.0, 3.0, 0.0)),
            variable("job_order"): Shuffled(),
        },
        repeat=repeat,
        seed=seed,
        folder=place,
    )


def scores(results: StudyResults) -> list[Score]:
    """Return the score of each controller."""
    all_scores = []
    for name in _controllers(results):
        rows = _rows(results, name)
        spreads = {}
        for measure in MEASURES:
            values = measure.values(results.columns)
            spreads[measure] = None if values is None else spread(values[rows])
        margins = MEASURES[0].values(results.columns)
        least = None if margins is None or np.isnan(margins[rows]).all() else margins[rows]
        worst = None if least is None else int(rows[int(np.nanargmin(least))])
        value = None if least is None else float(np.nanmin(least))
        all_scores.append(Score(name, spreads, value, worst))
    return all_scores


def paired_tests(results: StudyResults) -> list[PairedTest]:
    """Return the tests of all pairs of controllers by each measure in which they differ.

    Rows of one scene and one repetition have the same draws. Their differences are compared with
    differences of random signs (R. A. Fisher, "The Design of Experiments", 1935).
    """
    tests = []
    for one, other in itertools.combinations(_controllers(results), 2):
        for measure in MEASURES:
            values = measure.values(results.columns)
            if values is None:
                continue
            off = values[_rows(results, one)] - values[_rows(results, other)]
            off = off[~np.isnan(off)]
            interval = spread(off)
            if interval is not None and off.any():
                ends = (interval.mean, interval.low, interval.high)
                tests.append(PairedTest(one, other, measure, len(off), *ends, sign_flips(off)))
    return tests


def sign_flips(differences: Floats) -> float:
    """Return the share of random signs whose mean is at least as far from 0."""
    signs = np.random.default_rng(0).choice((-1.0, 1.0), size=(FLIPS, len(differences)))
    means = np.abs((signs * differences).mean(axis=1))
    as_far = int((means >= abs(differences.mean()) - 1e-12).sum())
    return (as_far + 1) / (FLIPS + 1)


def write_scoreboard(results: StudyResults) -> Path:
    """Write the page of the scoreboard and the worst trial of each controller. Return its path."""
    ranked = scores(results)
    links = {}
    for score in ranked:
        if score.worst_row is not None:
            path = save_trial(results.study, score.worst_row, results.folder)
            links[score.controller] = path.relative_to(results.folder).as_posix()
    path = results.folder / f"{NAME}.html"
    write_report_page(
        path,
        "scoreboard.html",
        {"figure": figure},
        scores=ranked,
        measures=MEASURES,
        tests=paired_tests(results),
        links=links,
        count=len(results),
        repeat=results.study.repeat,
        scenes=SCENES,
    )
    return path


def _controllers(results: StudyResults) -> list[str]:
    return [str(name) for name in dict.fromkeys(results.columns["controller"])]


def _rows(results: StudyResults, controller: str) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Return the rows of a controller in the same order of scene and repetition for all."""
    columns = results.columns
    keys = zip(columns["repetition"], columns["trial"], columns["controller"], strict=True)
    mine = [(k, row) for row, (*k, name) in enumerate(keys) if name == controller]
    return np.array([row for _, row in sorted(mine, key=lambda one: [*map(str, one[0])])])
