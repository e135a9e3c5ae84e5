"""`floorwalker ros2`: a trial as a simulator for ROS 2 and Nav2."""

from __future__ import annotations

from typing import Annotated

import typer

from .arguments import Duration, NoOwnCode, Personality, RecordingFolder, Rules, Seed, TrialName
from .run import changed, print_result, recording_of
from .terminal import say, taken_by


def ros2(
    trial: TrialName = "ariac2023",
    domain: Annotated[
        int | None, typer.Option(help="Domain of ROS. By default $ROS_DOMAIN_ID.")
    ] = None,
    namespace: Annotated[str, typer.Option(help="Namespace of topics and actions.")] = "",
    speed: Annotated[float, typer.Option(help="Simulated seconds per second.")] = 1.0,
    step: Annotated[
        bool, typer.Option("--step", help="Advance only by services of simulation_interfaces.")
    ] = False,
    out: RecordingFolder = None,
    personality: Personality = None,
    duration: Duration = None,
    seed: Seed = None,
    rules: Rules = None,
    no_own_code: NoOwnCode = False,
) -> None:
    """Serve a trial to ROS 2, in place of Nav2's loopback simulator."""
    from floorplan import UserError
    from sim import Simulation, Trial

    try:
        from ..ros2 import serve
    except ImportError as why:
        raise UserError(str(why)) from why
    loaded = Trial.load(trial, own_code=not no_own_code)
    chosen = changed(loaded, personality, duration, seed, rules)
    recording = recording_of(chosen.name, out)
    simulation = Simulation(chosen, recording)
    try:
        with taken_by(simulation.stop):
            serve(
                simulation,
                domain=domain,
                namespace=namespace,
                speed=speed,
                step=step,
                notice=lambda line: say(line, err=True),
            )
    finally:
        if simulation.has_started:
            finished = simulation.finish()
            recording.finish(finished)
        recording.close()
    print_result(finished, recording.folder, interrupted=simulation.stopped)
