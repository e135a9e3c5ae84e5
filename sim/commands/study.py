"""`floorwalker study` and `floorwalker report`."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..record.output import folder_for
from .arguments import NoOwnCode, complete_backend, complete_study, complete_trial
from .run import INTERRUPTED
from .terminal import plain_console, progress_bars, say, visible

if TYPE_CHECKING:
    from ..studies import Study, StudyResults
    from ..studies.repeats import UntilKeys


WIDTH = 120
"""Characters per line of the table if there is no terminal."""

SCOREBOARD = "scoreboard"
"""Name of the built-in study."""

SIGNIFICANT = 0.05
"""Differences with at least this p appear only on the page."""

BESIDE = 3
"""Characters that a column takes beside its text: blanks and a rule."""


def study(
    file: Annotated[
        str,
        typer.Argument(
            metavar="STUDY.yaml",
            help="Study file, or scoreboard: the built-in comparison of gantry controllers.",
            autocompletion=complete_study,
        ),
    ],
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Number of processes (default: number of cores).")
    ] = None,
    backend: Annotated[
        str,
        typer.Option(
            help="Backend of joblib, or dask for a Dask cluster.",
            autocompletion=complete_backend,
        ),
    ] = "loky",
    out: Annotated[
        Path | None,
        typer.Option(help="Folder of the results (default: studies/NAME)."),
    ] = None,
    controller: Annotated[
        list[str] | None,
        typer.Option(help="For scoreboard: a controller to compare. Repeat it for each."),
    ] = None,
    repeat: Annotated[
        int | None, typer.Option(min=1, help="For scoreboard: trials of each scene (default: 20).")
    ] = None,
    row: Annotated[int | None, typer.Option(help="Only write the trial file of this row.")] = None,
    no_own_code: NoOwnCode = False,
) -> None:
    """Run all variations of the trials of a study, or continue an interrupted study."""
    from ..studies import Study, save_trial

    compares = file == SCOREBOARD and not Path(file).exists()
    if not compares and (controller or repeat is not None):
        option = "--controller" if controller else "--repeat"
        raise typer.BadParameter("is for scoreboard only", param_hint=option)
    if compares:
        chosen = _scoreboard(controller or [], repeat, own_code=not no_own_code)
    else:
        chosen = Study.load(file, own_code=not no_own_code)
    folder = folder_for(chosen.name, "studies") if out is None else out
    if row is not None:
        say(str(save_trial(chosen, row, folder)))
        return
    try:
        results = carried_out(chosen, folder, jobs, backend)
    except KeyboardInterrupt:
        say(
            f"Stopped. Finished rows are kept in {folder}. Run the same command to continue.",
            err=True,
        )
        raise typer.Exit(INTERRUPTED) from None
    if compares:
        _print_scoreboard(results)
    else:
        _report(results)
    if failed := results.failed:
        number, error = next(iter(failed.items()))
        say(
            f"floorwalker: {len(failed)} of {len(results)} rows failed; row {number}: {error}",
            err=True,
        )
        raise typer.Exit(1)


def _scoreboard(controllers: list[str], repeat: int | None, *, own_code: bool) -> Study:
    from floorplan import UserError

    from ..studies.scoreboard import scoreboard

    if not own_code and any(":" in name for name in controllers):
        raise UserError("custom controllers are refused here (--no-own-code)")
    return scoreboard(controllers, repeat=20 if repeat is None else repeat)


def _print_scoreboard(results: StudyResults) -> None:
    """Print the score of each controller, and the significant paired tests."""
    from rich.table import Table

    from ..core.wording import figure, interval
    from ..studies.scoreboard import MEASURES, paired_tests, scores, write_scoreboard

    console = plain_console(WIDTH)
    table = Table(title=results.study.name, title_justify="left")
    for heading in ("Controller", "Least margin, m", *(measure.label for measure in MEASURES)):
        table.add_column(heading, justify="left" if heading == "Controller" else "right")
    for score in scores(results):
        means = (score.spreads[measure] for measure in MEASURES)
        cells = (
            "–" if one is None else f"{figure(one.mean)} ({interval(one.low, one.high)})"
            for one in means
        )
        table.add_row(score.controller, figure(score.least_margin), *cells)
    console.print(table)
    for test in paired_tests(results):
        if test.p < SIGNIFICANT:
            console.print(
                f"{test.one} − {test.other}: {test.measure.words} {figure(test.difference)}"
                f" ({interval(test.low, test.high)}), p = {test.p:.4f},"
                f" {test.count} pairs",
                highlight=False,
                soft_wrap=True,
            )
    console.print(f"Report: {write_scoreboard(results)}", highlight=False, soft_wrap=True)


def carried_out(chosen: Study, folder: Path, jobs: int | None, backend: str) -> StudyResults:
    """Run the missing rows of a study, with a progress bar and an estimate on a terminal."""
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

    from ..studies import run_study

    shown = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("rows,"),
        TimeRemainingColumn(),
        TextColumn("left"),
    )
    with progress_bars(*shown) as bars:
        bar = bars.add_task(visible(chosen.name), total=len(chosen))

        def begin(done: int) -> None:
            if 0 < done < len(chosen):
                say(f"Continuing after {done:,} of {len(chosen):,} rows.", err=True)
            # Rows that exist already would distort the estimate.
            bars.reset(bar, completed=done)

        return run_study(
            chosen,
            folder,
            jobs=jobs,
            backend=backend,
            begin=begin,
            progress=lambda done: bars.update(bar, completed=done),
        )


def column_width(texts: Iterable[str]) -> int:
    """Return the width of a column of these texts with its rule."""
    return max(map(len, texts), default=0) + BESIDE


def _report(results: StudyResults) -> None:
    """Print the means of every combination as a table, and the path of the report.

    The table has as many measures as fit. The names of the others are printed below.
    """
    from rich.table import Table

    from ..core.wording import figure

    compared = results.comparison
    table = Table(title=results.study.name, title_justify="left")
    for factor in compared.factors:
        table.add_column(factor, no_wrap=True)
    table.add_column("Runs", justify="right")
    named = [measure for measure in compared.spreads if measure.chief or measure.rare]
    measures = [measure for measure in named if compared.constant(measure) != 0.0]
    console = plain_console(WIDTH)
    groups = compared.groups
    keys = zip(compared.factors, *(group.values for group in groups), strict=True)
    room = console.width - 1 - sum(column_width(key) for key in (*keys, ("Runs",)))
    shown: list[list[str]] = []
    left_out = []
    for measure in measures:
        spreads = compared.spreads[measure]
        means = [figure(spread.mean) if spread else "–" for spread in spreads]
        width = column_width((*measure.label.split(), *means))
        if shown and width > room:
            left_out.append(measure.words)
            continue
        room -= width
        shown.append(means)
        # Columns without a width would be narrowed first, even if words break.
        table.add_column(measure.label, justify="right", overflow="fold", width=width - BESIDE)
    for k, group in enumerate(groups):
        table.add_row(*group.values, f"{len(group.rows):,}", *(means[k] for means in shown))
    console.print(table)
    if left_out:
        console.print(f"Only in the report: {', '.join(left_out)}", highlight=False)
    if nowhere := [measure.words for measure in named if measure not in measures]:
        console.print(f"0 in all rows: {', '.join(nowhere)}", highlight=False)
    if compared.identical:
        console.print(compared.identical, highlight=False, soft_wrap=True)
    if results.study.until is not None:
        console.print(_until(results, results.study.until), highlight=False, soft_wrap=True)
    console.print(f"Report: {results.folder / 'report.html'}", highlight=False, soft_wrap=True)


def _until(results: StudyResults, until: UntilKeys) -> str:
    """Return whether the wanted width was reached, or how many repetitions it needs."""
    width, repetitions = results.width(until.of), len(results) // len(results.study.combinations)
    words = f"{until.of}: interval of width {width:.3g} after {repetitions:,} repetitions"
    if width <= until.width or any(group.repeats > 1 for group in results.comparison.groups):
        return words
    needed = results.repetitions_needed(until.of, until.width)
    return f"{words}; a width of {until.width:g} needs about {needed:,}"


def report(
    source: Annotated[
        str,
        typer.Argument(
            metavar="SOURCE",
            help="Folder of a run, a trial to run, or a study file, whose missing rows are run.",
            autocompletion=complete_trial,
        ),
    ],
    out: Annotated[Path, typer.Option(help="HTML file, or PDF file with Chromium.")],
    results: Annotated[
        Path | None,
        typer.Option(help="Folder of the study's results (default: studies/NAME)."),
    ] = None,
    jobs: Annotated[
        int | None,
        typer.Option(min=1, help="Number of processes for a study (default: number of cores)."),
    ] = None,
    duration: Annotated[
        float | None, typer.Option(help="Duration in seconds of a trial to run.")
    ] = None,
    warm_up: Annotated[
        float | None,
        typer.Option(min=0, help="Seconds before which nothing counts (default: the trial's)."),
    ] = None,
    plant: Annotated[str, typer.Option(help="Plant, for the sign-off block.")] = "",
    revision: Annotated[str, typer.Option(help="Revision, for the sign-off block.")] = "",
    author: Annotated[str, typer.Option(help="Author, for the sign-off block.")] = "",
    date: Annotated[str, typer.Option(help="Date, for the sign-off block.")] = "",
    no_own_code: NoOwnCode = False,
) -> None:
    """Write a report for auditors: assumptions, laws, results and limitations."""
    from floorplan import UserError

    from ..core.entries import SignOff
    from ..studies import Study, safety_report
    from ..views.safety_page import require_writable
    from .sources import is_study, run_from

    require_writable(out)
    sign_off = SignOff(plant=plant, revision=revision, author=author, date=date)
    if not is_study(source):
        for option, value in (("--results", results), ("--jobs", jobs)):
            if value is not None:
                raise typer.BadParameter("is for studies only", param_hint=option)
        if (Path(source) / "results.csv").is_file():
            raise UserError(
                f"{source} contains results of a study; give the study file, with --results"
            )
        run = run_from(source, duration, own_code=not no_own_code)
        safety_report(run, out, warm_up=warm_up, sign_off=sign_off)
        say(str(out))
        return
    if duration is not None:
        raise typer.BadParameter("is for trials only; a study may vary it", param_hint="--duration")
    study = Study.load(source, own_code=not no_own_code)
    folder = folder_for(study.name, "studies") if results is None else results
    measured = carried_out(study, folder, jobs, "loky")
    with progress_bars() as bars:
        bar = bars.add_task("evaluating runs", total=len(study))
        safety_report(
            measured,
            out,
            jobs=jobs,
            progress=lambda done: bars.update(bar, completed=done),
            warm_up=warm_up,
            sign_off=sign_off,
        )
    say(str(out))
