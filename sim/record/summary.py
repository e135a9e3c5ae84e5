"""Summary of a run: its figures as recorded, and as words."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from contextlib import suppress
from typing import Any

from ..core.recorder import rounded
from .figures import FIGURES, PEOPLE, SummaryFigure
from .finished import Finished

_LACKING = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError)
"""Errors of a figure whose fields are missing in the summary, or have another form."""


def summarise(run: Finished) -> dict[str, Any]:
    """Return the summary of a run without its costs."""
    functions = {path: one.of for path, one in FIGURES.items() if one.of and one.only(run.trial)}
    own = {path: of for path, of in functions.items() if path.startswith(PEOPLE)}
    summary = {path: of(run) for path, of in functions.items() if path not in own}
    summary["people"] = {
        person.name: {path.removeprefix(PEOPLE): of(run, person) for path, of in own.items()}
        for person in run.people
    }
    if run.trial.machines or run.trial.fields:
        summary["machines"] = {
            name: {
                "kind": machine.shape.kind,
                **run.of_machines[name],
                **run.of_fields.get(name, {}),
            }
            for name, machine in run.machines.items()
        }
    figures: dict[str, Any] = rounded(summary)
    return figures


MOST_AT_LENGTH, MOST_PEOPLE = 5, 20
"""Maximum number of people with a line for each figure, and with figures."""

NOTHING = ("0", "0.0 s", "0.0 m", "none")
"""Amounts that are omitted if there are many people."""


def figures_in_words(summary: Mapping[str, Any], *, in_short: bool = True) -> list[tuple[str, str]]:
    """Return the most important figures of a summary: names and amounts.

    With `in_short`, many people have one line each. Otherwise each figure has a line. Figures are
    omitted if the summary lacks them, because it was recorded by another version or changed.
    """
    lines = []
    shown = [figure for figure in FIGURES.values() if figure.words]
    for above, figures in itertools.groupby(shown, lambda f: f.path.rpartition("NAME")[0]):
        together, owners = list(figures), [*_owners(summary, above)]
        many = above == PEOPLE.rpartition("NAME")[0] and len(owners) > MOST_AT_LENGTH
        if in_short and many:
            lines += [(name, _in_short(together, beside)) for name, beside in owners[:MOST_PEOPLE]]
            more = len(owners) - MOST_PEOPLE
            lines += [("others", f"{more} people, in the summary")] if more > 0 else []
            continue
        for name, beside in owners:
            lines += [(_line(figure, name), _amount(figure, beside)) for figure in together]
    return [(line, amount) for line, amount in lines if amount]


def trial_figures_in_words(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the figures of the whole trial that are not nothing."""
    shown = [one for one in FIGURES.values() if one.words and "NAME" not in one.path]
    amounts = [(one.label, _amount(one, summary)) for one in shown]
    return [(label, amount) for label, amount in amounts if amount and amount not in NOTHING]


def _in_short(figures: Iterable[SummaryFigure], beside: Any) -> str:
    """Return the figures of one of many people in one line, without those that are nothing."""
    personality, *amounts = ((one.label, _amount(one, beside)) for one in figures)
    phrases = [f"{label} {amount}" for label, amount in amounts if amount and amount not in NOTHING]
    return "; ".join([personality[1], *phrases])


def _owners(summary: Mapping[str, Any], above: str) -> Iterable[tuple[str, Any]]:
    """Return the parents of figures by name: the summary itself, or each entry of `above`."""
    if not above:
        return [("", summary)]
    entries = summary.get(above.strip("."))
    return entries.items() if isinstance(entries, Mapping) else ()


def _amount(figure: SummaryFigure, beside: Any) -> str:
    """Return a figure in words, or "" if it is not shown. `beside` contains it."""
    key = figure.path.rpartition("NAME")[2].removeprefix(".")
    with suppress(*_LACKING):
        if figure.words is not None:
            return figure.words(beside[key] if key else beside, beside)
    return ""


def _line(figure: SummaryFigure, name: str) -> str:
    """Return the label of a figure of the person or order of that name."""
    if "NAME" in figure.label:
        return figure.label.replace("NAME", name)
    return f"{name}: {figure.label}" if name else figure.label
