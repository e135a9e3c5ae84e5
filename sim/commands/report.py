"""`floorwalker report`: a safety report of a run or a study."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..core.folder_names import folder_for
from . import completion
from .arguments import NoOwnCode
from .consoles import progress_bars, say


def report(
    source: Annotated[
        str,
        typer.Argument(
            metavar="SOURCE",
            help="A run's folder, a trial (which is run), or a study file (of which is run what"
            " is not done yet).",
            autocompletion=completion.trial,
        ),
    ],
    out: Annotated[Path, typer.Option(help="The report: .html, or .pdf where there is Chromium.")],
    results: Annotated[
        Path | None,
        typer.Option(help="The folder with the results of the study (studies/NAME if not given)."),
    ] = None,
    jobs: Annotated[
        int | None,
        typer.Option(min=1, help="Processes for the runs of a study; all cores by default."),
    ] = None,
    duration: Annotated[
        float | None, typer.Option(help="Seconds to simulate of a trial, if not all of it.")
    ] = None,
    no_own_code: NoOwnCode = False,
) -> None:
    """Write a report that can be handed to an auditor.

    It has the assumptions, laws, figures and limits of a run or a study.
    """
    from floorplan import UserError
    from sim.commands.sources import is_study, run_from
    from sim.commands.study import carried_out
    from sim.studies import Study, safety_report
    from sim.views.safety_report.page import require_writable

    require_writable(out)
    if not is_study(source):
        for option, given in (("--results", results), ("--jobs", jobs)):
            if given is not None:
                raise typer.BadParameter("is for studies only", param_hint=option)
        if (Path(source) / "results.csv").is_file():
            raise UserError(f"{source} has the results of a study: give its file, with --results")
        safety_report(run_from(source, duration, own_code=not no_own_code), out)
        say(str(out))
        return
    if duration is not None:
        raise typer.BadParameter("is for trials only; a study may vary it", param_hint="--duration")
    study = Study.load(source, own_code=not no_own_code)
    folder = folder_for(study.name, "studies") if results is None else results
    measured = carried_out(study, folder, jobs, "loky")
    with progress_bars() as bars:
        bar = bars.add_task("looking at all runs", total=len(study))
        safety_report(
            measured, out, jobs=jobs, progress=lambda done: bars.update(bar, completed=done)
        )
    say(str(out))
