"""`floorwalker run`: simulate a trial and record it."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..core.folder_names import folder_for
from . import completion
from .arguments import Duration, NoOwnCode, Personality, RecordingFolder, Rules, Seed, TrialName
from .browser import open_in_browser, somebody_looks
from .consoles import progress_bars, say
from .interrupts import taken_by
from .notices import count_floor_notices, print_notices

if TYPE_CHECKING:
    from sim import LiveRun, Recording, Run, Simulation, Trial

INTERRUPTED = 130
"""The exit code of a command stopped by Ctrl-C, as shells have it."""

REPORTS = 200
"""Number of moves of the progress bar in a run."""


def run(
    trial: TrialName = "ariac2023",
    personality: Personality = None,
    controller: Annotated[
        str | None,
        typer.Option(
            help="Of the gantry: a built-in one, or package.module:name.",
            autocompletion=completion.controller,
        ),
    ] = None,
    planner: Annotated[
        str | None,
        typer.Option(
            help='Of everybody\'s paths: its name, or "BITstar: {samples_per_batch: 50}".',
            autocompletion=completion.planner,
        ),
    ] = None,
    duration: Duration = None,
    seed: Seed = None,
    rules: Rules = None,
    commands: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Repeat these: the commands.yaml of a run that was watched."
        ),
    ] = None,
    out: RecordingFolder = None,
    watch: Annotated[
        bool, typer.Option("--watch", help="Show it in the browser, to interfere with it too.")
    ] = False,
    speed: Annotated[
        float | None, typer.Option(metavar="X", help="With --watch: × real time (1).")
    ] = None,
    opened: Annotated[
        bool | None,
        typer.Option(
            "--open/--no-open",
            help="Open the page in the browser, or only say where it is.  [default: open on a"
            " terminal]",
            show_default=False,
        ),
    ] = None,
    no_trajectory: Annotated[
        bool, typer.Option("--no-trajectory", help="Leave out trajectory.csv, the largest file.")
    ] = False,
    no_own_code: NoOwnCode = False,
) -> None:
    """Simulate a trial and record it.

    The recording has its summary, events, motions, trajectory, and a page that replays it.
    """
    from ..trials.trial import Trial

    if speed is not None and not watch:
        raise typer.BadParameter("needs --watch", param_hint="--speed")
    if speed is not None and not (math.isfinite(speed) and speed > 0):
        raise typer.BadParameter(f"must be more than 0, not {speed:g}", param_hint="--speed")
    given = Trial.load(trial, own_code=not no_own_code)
    chosen = changed(given, personality, duration, seed, rules, controller, planner, commands)
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
    """Print how a run went; `typer.Exit` where it was interrupted, or not what was expected."""
    _report(finished, folder)
    if interrupted:
        say(f"Stopped at t = {finished.duration:.1f} s; what happened is kept.", err=True)
        raise typer.Exit(INTERRUPTED)
    if finished.unmet:
        for sentence in finished.unmet:
            say(f"floorwalker: {sentence}", err=True)
        raise typer.Exit(1)


def _warn_of_external(trial: Trial) -> None:
    """Print who does nothing here because they are driven from outside."""
    from ..people.programs import EXTERNAL

    waiting = [person.name for person in trial.people if person.personality == EXTERNAL]
    if trial.floorplan.gantry is not None and trial.gantry.controller == EXTERNAL:
        waiting.append("the gantry")
    if waiting:
        say(
            f"{trial.name}: {' and '.join(waiting)} can only be driven from outside, and"
            " nobody does; `floorwalker bridge` serves the trial to those who would",
            err=True,
        )


def _warn_of_undone(trial: Trial) -> None:
    """Print that jobs and orders are left undone because nothing does them."""
    if trial.gantry.controller == "parked" and (trial.gantry.jobs or trial.workload):
        say(f"{trial.name}: the gantry is parked and does no jobs; give it a controller", err=True)


def changed(
    trial: Trial,
    personality: str | None,
    duration: float | None,
    seed: int | None,
    rules: str | None,
    controller: str | None = None,
    planner: str | None = None,
    commands: Path | None = None,
) -> Trial:
    """Return the trial as the options change it; `TrialError` if it can't be run so."""
    from floorplan import is_file

    from ..machines.gantry.controllers import controller_source
    from ..people.planners import with_planner
    from ..trials.checks import check
    from ..trials.command_keys import commanded
    from ..trials.rules_file import find_rules
    from ..trials.shortening import lasting

    if personality is not None:
        path = Path(personality)
        trial = trial.with_personality(str(path.resolve()) if is_file(path) else personality)
    if controller is not None:
        controller_source(controller, trial.folder, own_code=trial.own_code)
        trial = replace(trial, gantry=replace(trial.gantry, controller=controller))
    if planner is not None:
        trial = with_planner(trial, planner)
    if duration is not None:
        trial = lasting(trial, duration)
    if seed is not None:
        trial = replace(trial, seed=seed)
    if rules is not None:
        trial = replace(trial, rules=find_rules(rules, own_code=trial.own_code))
    if commands is not None:
        trial = commanded(trial, commands)
    check(trial)
    return trial


def recording_of(name: str, out: Path | None, *, trajectory: bool = True) -> Recording:
    """Open the recording of the trial `name` in `out`, or else in a new folder in `runs`."""
    from ..runs.recording import Recording

    folder = folder_for(name, "runs") if out is None else out
    return Recording(folder, numbered=out is None, trajectory=trajectory)


def _carried_out(trial: Trial, recording: Recording) -> Run:
    """Return the run, which went on until its end or Ctrl-C."""
    from ..simulation import Simulation

    simulation = Simulation(trial, recording)
    return _kept(simulation, _advance, recording)


def _watched(trial: Trial, recording: Recording, speed: float, *, opened: bool) -> Run:
    """Return the same, and show the run in the browser meanwhile."""
    from ..live.live import LiveRun
    from ..simulation import Simulation

    live = LiveRun(trial.duration, speed=speed)
    simulation = Simulation(trial, recording, live)
    with taken_by(simulation.stop):
        simulation.start()
    with live.server as server:
        say(f"{server.url} shows it while it goes on", err=True)
        if opened and open_in_browser(server.url):
            live.wait_for_viewer()
        return _kept(simulation, live.advance, recording, live)


def _kept(
    simulation: Simulation,
    advance: Callable[[Simulation], None],
    *listeners: Recording | LiveRun,
) -> Run:
    """Return the run as far as it went; listeners get it also where the user's own code fails."""
    from ..core.own_code import broken_off

    def finish() -> Run:
        finished = simulation.finish()
        for listener in listeners:
            listener.finish(finished)
        return finished

    try:
        with broken_off(), taken_by(simulation.stop):
            advance(simulation)
    except Exception:
        with suppress(Exception):  # where nothing can be written that was the error already
            finish()
        raise
    return finish()


def _advance(simulation: Simulation) -> None:
    """Run to the end, or until it is stopped, with a progress bar on a terminal."""
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
    from sim.record.summary import figures_in_words

    summary = run.summary
    trial, floor = summary["trial"], summary["floorplan"]
    say(trial if trial == floor else f"{trial} on {floor}")
    figures = figures_in_words(summary)
    if (verdicts := run.verdicts) and not summary["interrupted"]:
        met = sum(verdict.met for verdict in verdicts)
        figures.append(("expectations met", f"{met} of {len(verdicts)}"))
    widest = max(len(name) for name, _ in figures)
    for name, value in figures:
        say(f"  {name:{widest}}  {value}")
    say(
        f"{run.duration:g} s in {summary['cpu_seconds']:.3f} s of CPU time:"
        f" {summary['realtime_factor']:,.0f} × real time"
    )
    say(f"{folder / 'replay.html'} shows it")
