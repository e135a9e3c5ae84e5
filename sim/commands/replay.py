"""`floorwalker replay`: look at a recorded run, or at two beside each other."""

from __future__ import annotations

import time
from itertools import takewhile
from pathlib import Path
from typing import Annotated, Any

import typer

from ..core.output import write_whole, writing
from .browser import open_in_browser
from .consoles import say


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
        int | None,
        typer.Option(min=0, max=65535, help="With --serve; any that is free if not given, or 0."),
    ] = None,
    no_open: Annotated[
        bool, typer.Option("--no-open", help="Open no browser, only say where the page is.")
    ] = False,
) -> None:
    """Replay a run in the browser; give two runs to compare them."""
    serve = serve or (other is not None and out is None)
    if port is not None and not serve:
        raise typer.BadParameter("needs --serve", param_hint="--port")
    page = _page(run, other) if serve or out is not None else ""
    if out is not None:
        _write(page, out)
    if serve:
        _serve(page, port or 0, opened=not no_open)
        return
    file = out if out is not None else _page_file(run)
    say(str(file))
    if not no_open and not open_in_browser(file.resolve().as_uri()):
        say("There is no browser to open it with; open it yourself.", err=True)


def _serve(page: str, port: int, *, opened: bool) -> None:
    from ..live.page_server import PageServer

    with PageServer(lambda: page, port=port) as server:
        say(server.url)
        say("Ctrl-C ends it.", err=True)
        if opened and not open_in_browser(server.url):
            say("There is no browser to open it with; open it yourself.", err=True)
        try:
            while True:
                time.sleep(3600)
        except KeyboardInterrupt:
            return


def _page(run: Path, other: Path | None) -> str:
    from floorplan import UserError

    from ..views.replay import render

    recordings = _recordings(run)
    if other is not None:
        recordings += _recordings(other)
    if len(recordings) > 2:
        raise UserError("a page shows two runs at most: give two runs, or one page of two")
    if other is not None:
        for recording, name in zip(recordings, _told_apart(run, other), strict=True):
            recording["folder"] = name
    return render(*recordings)


def _told_apart(one: Path, other: Path) -> tuple[str, str]:
    """Return the ends of two paths from where they differ, without a page's own name."""
    parts = [
        path.parts[:-1] if path.suffix == ".html" and path.stem == "replay" else path.parts
        for path in (one.absolute(), other.absolute())
    ]
    same = sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(*parts, strict=False)))
    first, second = ("/".join(names[same:] or names[-1:]) for names in parts)
    return first, second


def _write(page: str, file: Path) -> None:
    with writing(file):
        write_whole(file, page)


def _page_file(run: Path) -> Path:
    """Return the page of a run; it is written if the run was broken off before."""
    if not run.is_dir():
        _check_page(run)
        return run
    file = run / "replay.html"
    if not file.exists():
        _write(_page(run, None), file)
    return file


def _check_page(file: Path) -> None:
    """Say what is wrong with a page; `ValueError` where it is none, or can't say so itself."""
    from floorplan import LARGEST_RECORDED, InputError, UserError, read_text

    from ..views.replay import says_itself

    try:
        _recordings(file)
    except InputError:
        raise
    except UserError as why:
        if not file.exists() or not says_itself(read_text(file, InputError, LARGEST_RECORDED)):
            raise
        say(f"{why}; the page shows what there is of it", err=True)


def _recordings(path: Path) -> list[dict[str, Any]]:
    """Return the data of a run from its folder, or those of a page, of one run or two."""
    from floorplan import LARGEST_RECORDED, InputError, UserError, read_text

    from ..runs.run_folder import load_run
    from ..views.replay import recordings_in
    from ..views.replay_data import replay_data

    if not path.exists():
        raise UserError(f"{path}: there is no such folder or file")
    if path.is_dir():
        damages: list[str] = []
        recording = replay_data(load_run(path, damage=damages.append))
        for sentence in damages:
            say(f"{path}: {sentence}", err=True)
        return [{**recording, "notices": damages} if damages else recording]
    page = read_text(path, InputError, LARGEST_RECORDED)
    try:
        return recordings_in(page)
    except UserError as why:
        raise UserError(f"{path}: {why}") from None
