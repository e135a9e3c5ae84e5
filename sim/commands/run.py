"""`floorwalker run` and `floorwalker replay`."""

from __future__ import annotations

import math
import os
import sys
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import replace
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..record.output import folder_for, write_whole, writing
from .arguments import (
    Duration,
    NoOwnCode,
    Personality,
    RecordingFolder,
    Rules,
    Seed,
    TrialName,
    complete_controller,
    complete_planner,
)
from .terminal import (
    count_floor_notices,
    open_in_browser,
    print_notices,
    progress_bars,
    say,
    somebody_looks,
    taken_by,
)

if TYPE_CHECKING:
    from .. import LiveRun, Recording, Run, Simulation, Trial


INTERRUPTED = 130
"""Exit code of a command stopped by Ctrl-C, as in shells."""

REPORTS = 200
"""Number of updates of the progress bar in a run."""


def run(
    trial: TrialName = "ariac2023",
    personality: Personality = None,
    controller: Annotated[
        list[str] | None,
        typer.Option(
            help="Controller of gantries and vehicles: a name or package.module:name."
            " MACHINE=NAME is that of one machine. Repeat it for others.",
            autocompletion=complete_controller,
        ),
    ] = None,
    planner: Annotated[
        str | None,
        typer.Option(
            help='Path planner of all people: a name or "BITstar: {samples_per_batch: 50}".',
            autocompletion=complete_planner,
        ),
    ] = None,
    duration: Duration = None,
    seed: Seed = None,
    rules: Rules = None,
    commands: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Commands to repeat: commands.yaml of an earlier run."),
    ] = None,
    out: RecordingFolder = None,
    watch: Annotated[
        bool, typer.Option("--watch", help="Show the run in the browser, with controls.")
    ] = False,
    speed: Annotated[
        float | None,
        typer.Option(metavar="X", help="With --watch: simulated seconds per second (default: 1)."),
    ] = None,
    opened: Annotated[
        bool | None,
        typer.Option(
            "--open/--no-open",
            help="Open the replay page in the browser.  [default: open on a terminal]",
            show_default=False,
        ),
    ] = None,
    no_trajectory: Annotated[
        bool, typer.Option("--no-trajectory", help="Do not write trajectory.csv, the largest file.")
    ] = False,
    no_own_code: NoOwnCode = False,
) -> None:
    """Simulate a trial and record it.

    The recording contains the summary, events, motions, trajectory, and a replay page.
    """
    from ..trials.trial import Trial

    if speed is not None and not watch:
        raise typer.BadParameter("needs --watch", param_hint="--speed")
    if speed is not None and not (math.isfinite(speed) and speed > 0):
        raise typer.BadParameter(f"must be more than 0, not {speed:g}", param_hint="--speed")
    loaded = Trial.load(trial, own_code=not no_own_code)
    chosen = changed(
        loaded, personality, duration, seed, rules, controller or (), planner, commands
    )
    count_floor_notices(chosen.floorplan, str(trial))
    print_notices(chosen)
    _warn_of_external(chosen)
    _warn_of_undone(chosen)
    recording = recording_of(chosen.name, out, trajectory=not no_trajectory)
    try:
        if watch:
            finished = _watched(chosen, recording, speed or 1.0, opened=opened is not False)
        else:
            finished = _carried_out(chosen, recording)
    finally:
        recording.close()
    interrupted = finished.summary["interrupted"]
    wanted = somebody_looks(sys.stdout, os.environ) if opened is None else opened
    if wanted and not (watch or interrupted):
        open_in_browser((recording.folder / "replay.html").resolve().as_uri())
    print_result(finished, recording.folder, interrupted=interrupted)


def print_result(finished: Run, folder: Path, *, interrupted: bool) -> None:
    """Print the results of a run. `typer.Exit` if it was interrupted or expectations were unmet."""
    _report(finished, folder)
    if interrupted:
        say(
            f"Stopped at t = {finished.duration:.1f} s. The recording up to then is kept.", err=True
        )
        raise typer.Exit(INTERRUPTED)
    if finished.unmet:
        for sentence in finished.unmet:
            say(f"floorwalker: {sentence}", err=True)
        raise typer.Exit(1)


def _warn_of_external(trial: Trial) -> None:
    """Print the people and gantry that do nothing, because a program outside controls them."""
    from ..people.programs import EXTERNAL

    commanded = {one.send or one.person or one.machine for one in trial.commands}
    people = (person.name for person in trial.people if person.personality == EXTERNAL)
    waiting = [name for name in people if name not in commanded]
    gantry = trial.floorplan.gantry
    if gantry and trial.gantry.controller == EXTERNAL and "gantry" not in commanded:
        waiting.append("the gantry")
    if waiting:
        say(
            f"{trial.name}: {' and '.join(waiting)} will not move, because external programs"
            " control them; `floorwalker bridge` serves the trial to such programs",
            err=True,
        )


def _warn_of_undone(trial: Trial) -> None:
    """Print the jobs and orders that nothing will do."""
    if trial.gantry.controller == "parked" and (trial.gantry.jobs or trial.workload):
        say(
            f"{trial.name}: the gantry is parked and does no jobs; choose another --controller",
            err=True,
        )


def changed(
    trial: Trial,
    personality: str | None,
    duration: float | None,
    seed: int | None,
    rules: str | None,
    controllers: Iterable[str] = (),
    planner: str | None = None,
    commands: Path | None = None,
) -> Trial:
    """Return the trial with the changes of the options. `TrialError` if it is invalid."""
    from floorplan.files.reading import is_file

    from ..core.custom_code import CodeFolder
    from ..machines.kinds import with_controller
    from ..people.programs import with_planner
    from ..trials.building import lasting
    from ..trials.checks import check
    from ..trials.keys import commanded
    from ..trials.rules_file import find_rules

    if personality is not None:
        path = Path(personality)
        trial = trial.with_personality(str(path.resolve()) if is_file(path) else personality)
    for one in controllers:
        machine, _, controller = one.rpartition("=")
        trial = with_controller(trial, controller, machine)
    if planner is not None:
        trial = with_planner(trial, planner)
    if duration is not None:
        trial = lasting(trial, duration)
    if seed is not None:
        trial = replace(trial, seed=seed)
    if rules is not None:
        trial = replace(trial, rules=find_rules(rules, CodeFolder(allowed=trial.own_code)))
    if commands is not None:
        trial = commanded(trial, commands)
    check(trial)
    return trial


def recording_of(name: str, out: Path | None, *, trajectory: bool = True) -> Recording:
    """Open the recording of the trial `name` in `out`, or in a new folder in `runs`."""
    from ..runs.recording import Recording

    folder = folder_for(name, "runs") if out is None else out
    return Recording(folder, numbered=out is None, trajectory=trajectory)


def _carried_out(trial: Trial, recording: Recording) -> Run:
    """Return the run, which ended or was stopped by Ctrl-C."""
    from ..simulation import Simulation

    simulation = Simulation(trial, recording)
    return _kept(simulation, _advance, recording)


def _watched(trial: Trial, recording: Recording, speed: float, *, opened: bool) -> Run:
    """Return the run, and show it in the browser while it runs."""
    from ..live.live_run import LiveRun
    from ..simulation import Simulation

    live = LiveRun(trial.duration, speed=speed)
    simulation = Simulation(trial, recording, live)
    with taken_by(simulation.stop):
        simulation.start()
    with live.server as server:
        say(f"The run is shown live at {server.url}", err=True)
        if opened and open_in_browser(server.url):
            live.wait_for_viewer()
        return _kept(simulation, live.advance, recording, live)


def _kept(
    simulation: Simulation,
    advance: Callable[[Simulation], None],
    *listeners: Recording | LiveRun,
) -> Run:
    """Return the run up to its end or failure. Listeners get it even if custom code fails."""
    from floorplan.files.collector import frozen_collector

    from ..core.custom_code import broken_off

    def finish() -> Run:
        finished = simulation.finish()
        for listener in listeners:
            listener.finish(finished)
        return finished

    try:
        with frozen_collector(), broken_off(), taken_by(simulation.stop):
            advance(simulation)
    except Exception:
        with suppress(Exception):  # if nothing can be written, that was the first error
            finish()
        raise
    return finish()


def _advance(simulation: Simulation) -> None:
    """Run to the end or an interrupt, with a progress bar on a terminal."""
    duration = simulation.trial.duration
    if not sys.stderr.isatty():
        simulation.advance(duration)
        return

    with progress_bars() as progress:
        bar = progress.add_task("simulating", total=duration)
        for k in range(1, REPORTS + 1):
            if simulation.stopped:
                break
            simulation.advance(duration * k / REPORTS)
            progress.update(bar, completed=simulation.clock.now)


def _report(run: Run, folder: Path) -> None:
    from ..record.summary import figures_in_words

    summary = run.summary
    trial, floor = summary["trial"], summary["floorplan"]
    say(trial if trial == floor else f"{trial} on {floor}")
    figures = figures_in_words(summary)
    if (verdicts := run.verdicts) and not summary["interrupted"]:
        met = sum(verdict.met for verdict in verdicts)
        figures.append(("expectations met", f"{met} of {len(verdicts)}"))
        tightest = min(verdicts, key=lambda verdict: verdict.slack)
        slack = tightest.slack_in_words
        figures += [("least slack", f"{slack} ({tightest.expected})")] if slack else []
    widest = max(len(name) for name, _ in figures)
    for name, value in figures:
        say(f"  {name:{widest}}  {value}")
    say(
        f"Simulated {run.duration:g} s in {summary['cpu_seconds']:.3f} s of CPU time"
        f" ({summary['realtime_factor']:,.0f} × real time)"
    )
    say(f"Replay: {folder / 'replay.html'}")


def replay(
    run: Annotated[
        Path, typer.Argument(metavar="DIR|FILE", help="Folder of a run, or a replay page.")
    ],
    other: Annotated[
        Path | None,
        typer.Argument(
            metavar="OTHER", help="Second run, shown beside the first.", show_default=False
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the page to this file.")
    ] = None,
    serve: Annotated[
        bool, typer.Option("--serve", help="Serve the page on this machine until Ctrl-C.")
    ] = False,
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65535, help="With --serve: port (default: any free one)."),
    ] = None,
    no_open: Annotated[bool, typer.Option("--no-open", help="Do not open the browser.")] = False,
) -> None:
    """Replay a run in the browser, or compare two runs."""
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
        say("No browser was found. Open the page yourself.", err=True)


def _serve(page: str, port: int, *, opened: bool) -> None:
    from ..live.page_server import PageServer

    with PageServer(lambda: page, port=port) as server:
        say(server.url)
        say("Press Ctrl-C to stop.", err=True)
        if opened and not open_in_browser(server.url):
            say("No browser was found. Open the page yourself.", err=True)
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
        raise UserError("a page shows at most two runs")
    if other is not None:
        for recording, name in zip(recordings, _told_apart(run, other), strict=True):
            recording["folder"] = name
    return render(*recordings)


def _told_apart(one: Path, other: Path) -> tuple[str, str]:
    """Return the ends of two paths from where they differ, without names of pages."""
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
    """Return the page of a run, which is written first if the run was interrupted."""
    if not run.is_dir():
        _check_page(run)
        return run
    file = run / "replay.html"
    if not file.exists():
        _write(_page(run, None), file)
    return file


def _check_page(file: Path) -> None:
    """Report problems of a page. `ValueError` if it is invalid and cannot report them itself."""
    from floorplan import InputError, UserError
    from floorplan.files.reading import LARGEST_RECORDED, read_text

    from ..views.replay import says_itself

    try:
        _recordings(file)
    except InputError:
        raise
    except UserError as why:
        if not file.exists() or not says_itself(read_text(file, InputError, LARGEST_RECORDED)):
            raise
        say(f"{why}; the page shows the part that is intact", err=True)


def _recordings(path: Path) -> list[dict[str, Any]]:
    """Return the data of one or two runs from a folder or a page."""
    from floorplan import InputError, UserError
    from floorplan.files.reading import LARGEST_RECORDED, read_text

    from ..runs.recording import load_run
    from ..views.replay import recordings_in
    from ..views.replay_data import replay_data

    if not path.exists():
        raise UserError(f"{path}: no such file or folder")
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
