"""`floorwalker search`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .arguments import NoOwnCode, complete_backend, complete_study
from .run import INTERRUPTED
from .study import WIDTH, column_width
from .terminal import plain_console, progress_bars, say, visible

if TYPE_CHECKING:
    from rich.console import Console

    from ..searches import SearchResults, WorstCaseSearch
    from ..studies import Study

MOST_SHOWN = 10
"""Maximum number of evaluations in the table on a terminal."""


def search(
    file: Annotated[
        str,
        typer.Argument(metavar="STUDY.yaml", help="A study file.", autocompletion=complete_study),
    ],
    minimise: Annotated[
        str | None, typer.Option(metavar="FIGURE", help="Figure to make as small as can be.")
    ] = None,
    slack: Annotated[
        str | None, typer.Option(metavar="EXPECTATION", help="Expectation to break.")
    ] = None,
    below: Annotated[
        float | None, typer.Option(help="A trial breaks if the figure is less (0 if not given).")
    ] = None,
    sampler: Annotated[
        str | None, typer.Option(help="tpe, random, or package.module:Class.")
    ] = None,
    evaluations: Annotated[
        int | None, typer.Option(min=1, help="Trials to try (200 if not given).")
    ] = None,
    batch: Annotated[
        int | None, typer.Option(min=1, help="Trials that are tried together (8 if not given).")
    ] = None,
    cases: Annotated[
        int | None, typer.Option(min=0, help="Distinct cases to minimise (5 if not given).")
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Processes to run on; all cores by default.")
    ] = None,
    backend: Annotated[
        str,
        typer.Option(
            help="Where: a joblib backend, or dask for a Dask cluster.",
            autocompletion=complete_backend,
        ),
    ] = "loky",
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for the results (searches/NAME if not given)."),
    ] = None,
    no_own_code: NoOwnCode = False,
) -> None:
    """Search the trials of a study for those that break a controller, and minimise them.

    A search that was stopped goes on from there. The exit code is 1 if a trial breaks.
    """
    from ..studies import Study

    study = Study.load(file, own_code=not no_own_code)
    options = {
        "minimise": minimise,
        "slack": slack,
        "below": below,
        "sampler": sampler,
        "evaluations": evaluations,
        "batch": batch,
        "cases": cases,
    }
    wanted = _wanted(study, {key: value for key, value in options.items() if value is not None})
    results = _carried_out(wanted, out, jobs, backend)
    _report(results)
    if results.interrupted:
        say(
            f"Stopped; what is done is kept in {results.folder}: run the same command to go on.",
            err=True,
        )
        raise typer.Exit(INTERRUPTED)
    if results.broken:
        raise typer.Exit(1)


def _wanted(study: Study, options: dict[str, Any]) -> WorstCaseSearch:
    """Return the search of the study file, with the options instead of its keys."""
    from ..searches import Objective, WorstCaseSearch

    keys: dict[str, Any] = {}
    if study.search is not None:
        keys = study.search.model_dump(exclude_none=True)
    if "minimise" in options or "slack" in options:
        for key in ("minimise", "slack", "below"):
            keys.pop(key, None)
    keys |= options
    objective = Objective(
        keys.pop("minimise", ""), slack=keys.pop("slack", ""), below=keys.pop("below", 0.0)
    )
    return WorstCaseSearch(study=study, objective=objective, **keys)


def _carried_out(
    wanted: WorstCaseSearch, out: Path | None, jobs: int | None, backend: str
) -> SearchResults:
    """Run a search with a progress bar and the least value, or with lines."""
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

    from ..searches import SearchProgress, run_search

    shown = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[best]}", markup=False),
        TimeRemainingColumn(),
        TextColumn("left"),
    )
    with progress_bars(*shown) as bars:
        name = visible(wanted.study.name)
        total, shown_tenth = wanted.evaluations, 0
        bar = bars.add_task(name, total=total, best="")

        def progress(now: SearchProgress) -> None:
            nonlocal shown_tenth
            if now.minimising:
                bars.update(bar, description=f"{name}: minimising")
                if bars.disable:
                    say(f"{name}: minimising", err=True)
                return
            best = "" if now.best is None else f"least {_value(now.best)}"
            bars.update(bar, completed=now.done, best=best)
            if bars.disable and 10 * now.done // total > shown_tenth:
                shown_tenth = 10 * now.done // total
                say(f"{name}: {now.done:,} of {total:,} evaluations {best}".rstrip(), err=True)

        return run_search(wanted, out, jobs=jobs, backend=backend, progress=progress)


def _value(one: Any) -> str:
    from ..searches.report import shown

    return shown(one)


def _report(results: SearchResults) -> None:
    """Print the worst evaluations, the cases, and the value of the search."""
    from ..searches.report import rounded, size, where

    console = plain_console(WIDTH)
    _print_worst(results, console)
    for notice in results.notices:
        console.print(notice, highlight=False, soft_wrap=True)
    broken = len(results.broken)
    console.print(
        f"{broken:,} of {len(results):,} evaluations broke {results.objective}"
        if broken
        else f"nothing broke {results.objective}",
        highlight=False,
    )
    for case in results.cases:
        if case.path is not None and case.minimised is not None:
            value = case.minimised.value
            least = "" if value is None else f"; {results.objective} {rounded(value)}"
            console.print(
                f"{case.path}: {', '.join(size(case))}{least}; {where(case.situation)}",
                highlight=False,
                soft_wrap=True,
            )
    console.print(results.worth, highlight=False, soft_wrap=True)
    console.print(f"Report: {results.folder / 'report.html'}", highlight=False, soft_wrap=True)


def _print_worst(results: SearchResults, console: Console) -> None:
    """Print the worst evaluations with as many columns as fit, and the names of the others."""
    from rich.table import Table

    from ..searches.report import short, shown, varying

    ranked = sorted(results.evaluations, key=lambda one: (one.rank, one.number))
    ranked = [one for one in ranked if one.result != "no trial"][:MOST_SHOWN]
    title = f"{results.study.name}: the {len(ranked)} worst of {len(results):,} evaluations"
    table = Table(title=title, title_justify="left")
    columns = {"No.": [str(one.number) for one in ranked], "Value": [shown(one) for one in ranked]}
    for heading in columns:
        table.add_column(heading, justify="right", no_wrap=True)
    room = console.width - 1 - sum(column_width((key, *columns[key])) for key in columns)
    left_out = []
    for name in varying(results):
        cells = [short(one.values.get(name, "")) for one in ranked]
        if (width := column_width((name, *cells))) > room:
            left_out.append(name)
            continue
        room -= width
        columns[name] = cells
        table.add_column(name, no_wrap=True)
    for row in zip(*columns.values(), strict=True):
        table.add_row(*row)
    console.print(table)
    if left_out:
        console.print(f"Only in the report: {', '.join(left_out)}", highlight=False, soft_wrap=True)
