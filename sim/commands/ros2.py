"""`floorwalker ros2`: a trial as a simulator for ROS 2 and Nav2."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from .arguments import Duration, NoOwnCode, Personality, RecordingFolder, Rules, Seed, TrialName
from .run import changed, print_result, recording_of
from .terminal import say, taken_by

if TYPE_CHECKING:
    from ..runs.recording import Recording
    from ..runs.run import Run
    from ..simulation import Simulation
    from ..trials.trial import Trial


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

    from ..trials.trial import Trial

    try:
        from ..ros2 import serve
    except ImportError as why:
        raise UserError(str(why)) from why
    loaded = Trial.load(trial, own_code=not no_own_code)
    chosen = changed(loaded, personality, duration, seed, rules)
    served = _Served(chosen, recording_of(chosen.name, out))
    try:
        with taken_by(lambda: served.simulation.stop()):
            serve(
                served.simulation,
                domain=domain,
                namespace=namespace,
                speed=speed,
                step=step,
                notice=lambda line: say(line, err=True),
                restart=served.restart,
            )
    finally:
        finished = served.finish()
    if finished is not None:
        folder, interrupted = served.recording.folder, served.simulation.stopped
        print_result(finished, folder, interrupted=interrupted)


class _Served:
    """Simulation that is served, and its recording. Each restart begins another of both."""

    def __init__(self, trial: Trial, recording: Recording) -> None:
        self._trial = trial
        self._folder = recording.folder
        self._begin(recording)

    def _begin(self, recording: Recording) -> None:
        from ..simulation import Simulation

        self.recording = recording
        self.simulation = Simulation(self._trial, recording)

    def restart(self) -> Simulation:
        """Finish the simulation, and return the next one, whose folder has a number."""
        from ..runs.recording import Recording

        before = self.simulation
        self.finish()
        say(f"recorded in {self.recording.folder}", err=True)
        self._begin(Recording(self._folder, numbered=True))
        if before.stopped:  # by Ctrl-C, which may come at any point
            self.simulation.stop()
        return self.simulation

    def finish(self) -> Run | None:
        """Finish the recording of the simulation, if it has started."""
        finished = None
        if self.simulation.has_started:
            finished = self.simulation.finish()
            self.recording.finish(finished)
        self.recording.close()
        return finished
