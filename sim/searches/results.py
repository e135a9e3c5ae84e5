"""Results of a search: its evaluations, its cases, and their statistical value."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import NamedTuple

from floorplan.files.dataclass import dataclass
from floorplan.files.fields import brief

from ..studies.design import Study
from .evaluations import Evaluation, upper_bound
from .minimising import Minimised
from .objective import Objective, Situation
from .space import Space


@dataclass(frozen=True, kw_only=True)
class SearchProgress:
    """Progress of a search: the number of evaluations, and the one with the least value."""

    done: int
    best: Evaluation | None
    minimising: bool = False


@dataclass(frozen=True)
class Case:
    """A distinct case that breaks the objective: its evaluation and its minimised trial.

    `path` is the trial file. It is None if the case does not break again or the search was stopped.
    """

    evaluation: Evaluation
    minimised: Minimised | None = None
    path: Path | None = None

    @property
    def situation(self) -> Situation:
        """Situation of the minimised trial, or of the evaluation if there is none."""
        if self.minimised is None or self.minimised.value is None:
            return self.evaluation.situation
        return self.minimised.situation

    @property
    def replay(self) -> Path | None:
        """The replay page beside the trial file."""
        return None if self.path is None else self.path.with_name(f"{stem(self.path)}.html")

    @property
    def film(self) -> str:
        """Command that films it in the folder of the trial file, empty without a file."""
        if self.path is None:
            return ""
        trial, film = (shlex.quote(name) for name in (self.path.name, f"{stem(self.path)}.mp4"))
        return f"floorwalker render {trial} --out {film}"


class BreakingRate(NamedTuple):
    """Number of broken random trials, of all random trials, and the upper bound of their rate."""

    broken: int
    drawn: int
    bound: float


@dataclass(frozen=True, kw_only=True)
class SearchResults:
    """Results of a search: all evaluations, and the worst distinct cases among them."""

    __repr__ = brief

    study: Study
    objective: Objective
    space: Space
    folder: Path
    sampler: str
    evaluations: tuple[Evaluation, ...]
    cases: tuple[Case, ...] = ()
    interrupted: bool = False
    notices: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return the number of evaluations."""
        return len(self.evaluations)

    @property
    def broken(self) -> list[Evaluation]:
        """The evaluations that break the objective, the worst first."""
        breaking = [one for one in self.evaluations if one.is_break(self.objective)]
        return sorted(breaking, key=lambda one: (one.rank, one.number))

    @property
    def best(self) -> Evaluation | None:
        """The evaluation with the least value."""
        return least(self.evaluations)

    @property
    def no_trial(self) -> list[Evaluation]:
        """The evaluations whose values make no trial."""
        return [one for one in self.evaluations if one.result == "no trial"]

    @property
    def rate(self) -> BreakingRate:
        """Rate of breaking random trials.

        Only random trials count, because samplers prefer points that they expect to be bad.
        """
        drawn = [one for one in self.evaluations if one.is_random and one.result != "no trial"]
        broken = sum(one.is_break(self.objective) for one in drawn)
        bound = upper_bound(broken, len(drawn)) if drawn else 1.0
        return BreakingRate(broken, len(drawn), bound)

    @property
    def worth(self) -> str:
        """Sentence about the rate at which trials break."""
        broken, drawn, bound = self.rate
        chosen = len(self.evaluations) - len(self.no_trial) - drawn
        if not drawn:
            return "No trial was random: the search says nothing about how many trials break."
        many = "none" if not broken else f"{broken:,}"
        share = float(f"{100 * bound:.2g}")
        sentence = (
            f"Of {drawn:,} random trials {many} broke: with 95 % confidence at most"
            f" {share:g} % of the trials of this study break."
        )
        if chosen:
            sentence += f" The other {chosen:,} were chosen by the sampler and carry no rate."
        return sentence


def least(tried: tuple[Evaluation, ...] | list[Evaluation]) -> Evaluation | None:
    """Return the evaluation with the least value, or None if none has a value."""
    ranked = [one for one in tried if one.result == "error" or one.value is not None]
    return min(ranked, key=lambda one: (one.rank, one.number), default=None)


def stem(path: Path) -> str:
    """Return the name of a trial file without its endings."""
    return path.name.removesuffix(".trial.yaml")
