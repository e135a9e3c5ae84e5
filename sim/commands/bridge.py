"""`floorwalker bridge`: a trial over the rosbridge protocol, or an agent of a remote trial."""

from __future__ import annotations

import ipaddress
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .arguments import Duration, NoOwnCode, Personality, RecordingFolder, Rules, Seed, TrialName
from .run import INTERRUPTED, changed, print_result, recording_of
from .terminal import leave_to_asyncio, open_in_browser, say

if TYPE_CHECKING:
    import socket

    import bdi
    from sim import Trial
    from sim.bridge import Session


def bridge(
    trial: TrialName = "ariac2023",
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="Port to listen on, or 0 for any free one.")
    ] = 9090,
    speed: Annotated[
        float,
        typer.Option(help="Simulated seconds per second, or 0 for as fast as all clients follow."),
    ] = 1.0,
    hold: Annotated[
        bool, typer.Option("--hold", help="Start when /ariac/start_competition is called.")
    ] = False,
    grace: Annotated[
        float,
        typer.Option(
            min=0.0,
            help="Time in seconds for agents to get ready before a paced trial starts.",
        ),
    ] = 3.0,
    origin: Annotated[
        list[str] | None,
        typer.Option(
            metavar="ORIGIN",
            help="Origin of allowed web pages, such as http://host:8080; repeat for more.",
        ),
    ] = None,
    out: RecordingFolder = None,
    watch: Annotated[
        bool, typer.Option("--watch", help="Show the run in the browser, with controls.")
    ] = False,
    opened: Annotated[
        bool,
        typer.Option("--open/--no-open", help="With --watch: open the browser."),
    ] = True,
    to: Annotated[
        str | None,
        typer.Option(metavar="URL", help="Serve through the rosbridge server at this address."),
    ] = None,
    connect: Annotated[
        str | None,
        typer.Option(metavar="URL", help="Act as the agent at this rosbridge instead of serving."),
    ] = None,
    waypoints: Annotated[
        bool,
        typer.Option("--waypoints", help="With --connect: plan paths and send their waypoints."),
    ] = False,
    personality: Personality = None,
    duration: Duration = None,
    seed: Seed = None,
    rules: Rules = None,
    no_own_code: NoOwnCode = False,
) -> None:
    """Serve a trial to ROS over rosbridge, or act as the agent of one."""
    from sim import Trial

    loaded = Trial.load(trial, own_code=not no_own_code)
    chosen = changed(loaded, personality, duration, seed, rules)
    if connect is not None:
        from sim.bridge import driven_person

        for name, given_too in (("--watch", watch), ("--to", to is not None)):
            if given_too:
                raise typer.BadParameter("cannot be combined with --connect", param_hint=name)
        _be_the_agent(chosen, driven_person(loaded), connect, waypoints)
    else:
        _serve(chosen, to, host, port, speed, hold, grace, origin or [], out, watch, opened)


def _serve(
    trial: Trial,
    to: str | None,
    host: str,
    port: int,
    speed: float,
    hold: bool,
    grace: float,
    origins: list[str],
    out: Path | None,
    watch: bool,
    opened: bool,
) -> None:
    import asyncio
    from contextlib import ExitStack

    from sim import LiveRun
    from sim.bridge import Exchange, OriginError, Origins, Session, Workcell, listen_at

    if not (math.isfinite(speed) and speed >= 0):
        raise typer.BadParameter(f"must be 0 or more, not {speed:g}", param_hint="--speed")
    if to is not None and not speed:
        raise typer.BadParameter("must be more than 0 with --to", param_hint="--speed")
    try:
        trusted = Origins(origins)
    except OriginError as why:
        raise typer.BadParameter(str(why), param_hint="--origin") from None
    at = listen_at(host, port) if to is None else None
    if to is None and not _is_loopback(host):
        _notice(f"warning: anyone who can reach {host} can control the trial without a password")
    recording = recording_of(trial.name, out)
    live = LiveRun(trial.duration, speed=speed or 1.0) if watch else None
    listeners = (recording,) if live is None else (recording, live)
    interrupted = False
    with ExitStack() as shown:
        try:
            exchange = Exchange()
            workcell = Workcell(trial, exchange, *listeners)
            try:
                session = Session(
                    workcell,
                    exchange,
                    speed=speed,
                    hold=hold,
                    grace=grace,
                    notice=_notice,
                    origins=trusted,
                    viewer=live,
                )
                if live is not None:
                    shown.enter_context(live.server)
                    _show(live.server.url, opened=opened)
                leave_to_asyncio()
                asyncio.run(_open_and_run(session, at, to))
            except KeyboardInterrupt:
                interrupted = True
            finally:
                finished = workcell.simulation.finish()
                for listener in listeners:
                    listener.finish(finished)
        finally:
            recording.close()
    print_result(finished, recording.folder, interrupted=interrupted)


def _show(url: str, *, opened: bool) -> None:
    _notice(f"The run is shown live at {url}")
    if opened:
        open_in_browser(url)


async def _open_and_run(session: Session, at: socket.socket | None, to: str | None) -> None:
    if to is None:
        await session.open(at=at)
    else:
        await session.connect(to)
    await session.run()


def _be_the_agent(trial: Trial, who: int | None, url: str, waypoints: bool) -> None:
    import asyncio
    import json

    from sim.bridge import BridgeError, RemoteAgent

    def show(t: float, **what: str) -> None:
        say(json.dumps({"t": round(t, 9), **what}, ensure_ascii=False))

    def did(t: float, action: bdi.Literal) -> None:
        show(t, action=str(action))

    def said(t: float, text: str) -> None:
        show(t, print=text)

    if who is None:
        raise BridgeError(f"{trial.name} contains no person to control")
    agent = RemoteAgent(
        url, trial, trial.people[who], waypoints=waypoints, did=did, said=said, notice=_notice
    )
    try:
        leave_to_asyncio()
        asyncio.run(agent.run())
    except KeyboardInterrupt:
        raise typer.Exit(INTERRUPTED) from None


def _notice(text: str) -> None:
    say(text, err=True)


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
