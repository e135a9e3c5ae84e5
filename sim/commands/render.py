"""`floorwalker render`: a run as a moving picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from .arguments import NoOwnCode, Source
from .consoles import progress_bars, say


def render(
    source: Source,
    out: Annotated[Path, typer.Option(help="The film: .gif or .mp4.")],
    speed: Annotated[float, typer.Option(help="How much faster than in reality.")] = 8.0,
    fps: Annotated[int, typer.Option(help="Pictures a second.")] = 20,
    width: Annotated[int, typer.Option(help="Pixels.")] = 720,
    begin: Annotated[float, typer.Option("--from", help="Film from this time on, seconds.")] = 0.0,
    end: Annotated[
        float | None, typer.Option("--to", help="Film up to this time, seconds.")
    ] = None,
    view: Annotated[
        Literal["plot", "2d", "3d", "eyes"],
        typer.Option(help="As it is plotted, or as its page shows it, which takes Chromium."),
    ] = "plot",
    follow: Annotated[
        str,
        typer.Option(metavar="NAME", help="Keep this body in the middle of the page's view."),
    ] = "",
    dark: Annotated[bool, typer.Option("--dark", help="Film the page in dark colours.")] = False,
    no_own_code: NoOwnCode = False,
) -> None:
    """Film a run: a GIF, or an MP4."""
    from sim.commands.sources import run_from
    from sim.views import plots

    plots.require_renderable(out, view)
    run = run_from(source, own_code=not no_own_code)
    within = (begin, float("inf") if end is None else end)
    with progress_bars() as progress:
        bar = progress.add_task("filming", total=1.0)
        plots.render(
            run,
            out,
            speed=speed,
            fps=fps,
            width=width,
            within=within,
            view=view,
            follow=follow,
            dark=dark,
            progress=lambda share: progress.update(bar, completed=share),
        )
    say(str(out))
