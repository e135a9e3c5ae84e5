"""Tables and charts of a study's measures, as a safety report has them."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

from markupsafe import Markup

from ..views.safety_report.parts import Chart, Facts, Part, Points, Table
from .comparison import Comparison, Measure, Spread
from .effects import Effect, contrasts
from .report import digits_of, figure, signed
from .sensitivity import Trend, sensitivities, sensitivity_chart

ACROSS = 6
"""Measures in one table: more do not fit on a page."""

MOST_CONTRASTS = 60
"""Pairs of combinations that are set against each other."""


def figures(compared: Comparison) -> list[Part]:
    """Return the means of each combination, a few measures at a time, and what differs."""
    varying = [m for m in compared.spreads if compared.constant(m) is None]
    parts: list[Part] = []
    for k in range(0, len(varying), ACROSS):
        some = varying[k : k + ACROSS]
        heads = (*compared.factors, "runs", *(measure.label for measure in some))
        rows = [
            (*group.values, f"{len(group.rows):,}", *_means(compared, some, place))
            for place, group in enumerate(compared.groups)
        ]
        first = len(compared.factors)
        parts.append(Table(heads, rows, figures=frozenset(range(first, len(heads)))))
    same = [
        (measure.words, f"{figure(value)} {measure.unit}".strip())
        for measure in compared.spreads
        if (value := compared.constant(measure)) is not None
    ]
    if same:
        parts.append(Facts(same, "The same in every run"))
    return [*parts, *_differences(compared)]


def _means(compared: Comparison, measures: Sequence[Measure], place: int) -> Iterator[str]:
    for measure in measures:
        one = compared.spreads[measure][place]
        yield "–" if one is None else _mean(one, digits_of(compared.spreads[measure]))


def _mean(one: Spread, digits: int | None = None) -> str:
    """Return a mean, and below it its interval, where it has a width."""
    low, high = figure(one.low, digits), figure(one.high, digits)
    if low == high:
        return figure(one.mean, digits)
    return _above(figure(one.mean, digits), f"{low} … {high}")


def _above(value: str, interval: str) -> str:
    return Markup("{}<small>{}</small>").format(value, interval)


def _differences(compared: Comparison) -> Iterator[Table]:
    found = list(itertools.islice(contrasts(compared), MOST_CONTRASTS))
    if not found:
        return
    measures = [*found[0].effects]
    words = (
        "Cliff's delta of combinations that differ in one thing: how often a run of the first has a"
        " higher figure than one of the second, less how often a lower one; with its interval of"
        " 95 % (bootstrap over repetitions)."
    )
    for k in range(0, len(measures), ACROSS):
        some = measures[k : k + ACROSS]
        heads = ("first", "second", *(measure.title for measure in some))
        rows = [
            (one.one.label, one.other.label, *(_delta(one.effects[m]) for m in some))
            for one in found
        ]
        figures = frozenset(range(2, len(heads)))
        yield Table(heads, rows, "" if k else "Differences", "" if k else words, figures)


def _delta(effect: Effect | None) -> str:
    if effect is None:
        return "–"
    return _above(signed(effect.delta), f"{signed(effect.low)} … {signed(effect.high)}")


def sensitivity(compared: Comparison) -> Iterator[Part]:
    """Yield how far the telling measures change along each factor, as a table and as charts."""
    if not compared.factors:
        yield Points(("Nothing was varied on a grid.",))
        return
    found = list(sensitivities(compared))
    rows = [
        (measure.label, *(_swing(effects, factor) for factor in compared.factors))
        for measure, effects in found
    ]
    words = "How far the means of all runs with one value are from those with another, at the most."
    heads = ("figure", *compared.factors)
    yield Table(heads, rows, "Swings", words, frozenset(range(1, len(heads))))
    for measure, effects in found:
        element = sensitivity_chart(compared, measure, effects)
        if element is not None:
            yield Chart(
                measure.title,
                "Dots are means of all runs with that value, with their intervals of 95 %; faint"
                " lines are single combinations of what else was varied.",
                element,
            )


def _swing(trends: Sequence[Trend], factor: str) -> str:
    return next((figure(one.swing) for one in trends if one.factor == factor), "–")
