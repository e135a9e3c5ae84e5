"""`floorwalker replay`: look at a recorded run, or at two beside each other."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import typer

from ..pages.browser import open_in_browser


def replay(
    run: Annotated[
        Path, typer.Argument(metavar="DIR|FILE", help="A run's folder, or a replay page.")
    ],
    other: Annotated[
        Path | None,
        typer.Argument(
            metavar="OTHER", help="Another one, to be shown beside it.", show_default=False
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the page there.")] = None,
    serve: Annotated[
        bool, typer.Option("--serve", help="Serve it to this machine until Ctrl-C.")
    ] = False,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="With --serve; 0 takes any that is free.")
    ] = 0,
    no_open: Annotated[
        bool, typer.Option("--no-open", help="Open no browser, only say where the page is.")
    ] = False,
) -> None:
    """Replay a run in the browser; give two runs to compare them."""
    if serve or (other is not None and out is None):
        _serve(_page(run, other), port, opened=not no_open)
        return
    if out is not None:
        out.write_text(_page(run, other), encoding="utf-8", newline="\n")
        file = out
    else:
        file = _page_file(run)
    typer.echo(str(file))
    if not no_open and not open_in_browser(file.resolve().as_uri()):
        typer.echo("There is no browser to open it with; open it yourself.", err=True)


def _serve(page: str, port: int, *, opened: bool) -> None:
    from ..pages.page_server import PageServer

    with PageServer(lambda: page, port=port) as server:
        typer.echo(server.url)
        typer.echo("Ctrl-C ends it.", err=True)
        if opened and not open_in_browser(server.url):
            typer.echo("There is no browser to open it with; open it yourself.", err=True)
        try:
            while True:
                time.sleep(3600)
        except KeyboardInterrupt:
            return


def _page(run: Path, other: Path | None) -> str:
    from ..pages.replay import render

    return render(_recording(run), None if other is None else _recording(other))


def _page_file(run: Path) -> Path:
    """The page of a run; it is written if the run was broken off before."""
    from ..pages.replay import render

    if not run.is_dir():
        _recording(run)
        return run
    file = run / "replay.html"
    if not file.exists():
        page = render(_recording(run))
        file.write_text(page, encoding="utf-8", newline="\n")
    return file


def _recording(path: Path) -> dict[str, Any]:
    """What a page shows of a run, from its folder or from its page."""
    from ..pages.replay import recording_in
    from ..pages.replay_data import replay_data
    from ..recordings.run_folder import load_run

    if not path.exists():
        raise ValueError(f"{path}: there is no such folder or file")
    if path.is_dir():
        return replay_data(load_run(path))
    try:
        return recording_in(path.read_text(encoding="utf-8"))
    except UnicodeDecodeError:
        raise ValueError(f"{path}: is no replay page: it is not UTF-8 text") from None
    except ValueError as why:
        raise ValueError(f"{path}: {why}") from None
