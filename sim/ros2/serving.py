"""Serve a simulation to ROS 2: the node, and its time."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import redirect_stdout
from functools import partial
from io import StringIO

import rclpy
from rclpy.exceptions import NameValidationException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.validate_namespace import validate_namespace

from floorplan import UserError

from ..cell import Cell, Pace
from ..cell.signals import POSES
from ..competition import CompetitionTopics, add_gantry
from ..competition.topics import ENDED, STARTED
from ..competition.transport import plain, prefix_of
from ..simulation import Simulation
from .actions import Action
from .control import Control
from .entities import Entities
from .frames import add_frames, publish_map
from .machines import VehicleTopics, gantry_action
from .monitoring import DIAGNOSTICS, add_markers, add_monitoring
from .navigation import navigation_of
from .node import USUAL_RATE, CellNode
from .people import People

try:
    # Since Kilted. It does not look through all entities of the node before each callback.
    from rclpy.experimental import EventsExecutor as Executor
except ImportError:
    from rclpy.executors import SingleThreadedExecutor as Executor

LONGEST_WAIT = 0.1
"""Seconds. How soon the server sees that it was stopped."""

LAST_WAIT = 0.5
"""Seconds at the end of the run in which the results of goals are sent."""

TRIGGER, STARTED_ALREADY = "std_srvs/Trigger", {"success": True, "message": "started already"}

LAST_DOMAIN = 232
"""Highest domain of which DDS can calculate the ports. It ends the process for higher ones."""


class RosError(UserError):
    """A node that ROS cannot start."""


def serve(
    simulation: Simulation,
    *,
    domain: int | None = None,
    namespace: str = "",
    speed: float = 1.0,
    step: bool = False,
    notice: Callable[[str], None] = lambda _: None,
    restart: Callable[[], Simulation] | None = None,
) -> None:
    """Serve a simulation to ROS 2 until its trial is over.

    Parameters
    ----------
    simulation : Simulation
        Simulation, which is started. The caller finishes it.
    domain : int, optional
        Domain of ROS, by default `ROS_DOMAIN_ID`.
    namespace : str, optional
        Namespace of topics, services and actions, except `/clock`, `/tf`, `/tf_static` and
        `/diagnostics`.
    speed : float, optional
        Simulated seconds per second.
    step : bool, optional
        Advance only by the services of simulation_interfaces.
    notice : callable, optional
        Function that gets lines for the user.
    restart : callable, optional
        Function that services call which reset the simulation. It returns another one of the
        same trial, which is served from then on. By default that one is not recorded.

    Raises
    ------
    RosError
        If domain or namespace are not valid, or `speed` is given with `step`.
    """
    if domain is not None and not 0 <= domain <= LAST_DOMAIN:
        raise RosError(f"domain must be from 0 to {LAST_DOMAIN}, not {domain}")
    if step and speed != 1.0:
        raise RosError(f"speed {speed:g} has no effect with step, in which services advance time")
    pace = Pace(simulation, speed=speed, step=step)
    context, signals = rclpy.Context(), SignalHandlerOptions.NO
    try:
        validate_namespace(f"/{namespace.lstrip('/')}")
        rclpy.init(args=[], context=context, domain_id=domain, signal_handler_options=signals)
        node = rclpy.create_node("floorwalker", namespace=namespace, context=context)
    except (RuntimeError, ValueError, NameValidationException) as why:
        raise RosError(f"ROS cannot start the node: {' '.join(str(why).split())}") from why
    try:
        begin_again = restart or partial(Simulation, simulation.trial)
        _RosServer(node, simulation, pace, notice, begin_again).run()
    finally:
        rclpy.shutdown(context=context)


class _RosServer:
    """Node and pace of a simulation."""

    def __init__(
        self,
        node: Node,
        simulation: Simulation,
        pace: Pace,
        notice: Callable[[str], None],
        restart: Callable[[], Simulation],
    ) -> None:
        self._restart = restart
        self._pace = pace
        self._cell = cell = Cell(simulation, pace)
        self._ros = ros = CellNode(node, notice)
        machines = simulation.machines.values()
        vehicles = [one.name for one in machines if one.shape.category == "vehicle"]
        self._vehicles = [
            VehicleTopics(ros, cell, name, prefix_of(simulation, name)) for name in vehicles
        ]
        add_frames(ros, cell, self._vehicles)
        add_monitoring(ros, cell)
        add_markers(ros, cell)
        self._actions: list[Action] = []
        self._enter: Callable[[int], None] = lambda phase: None
        if simulation.gantry is not None:
            self._enter = CompetitionTopics(cell, ros).enter
            ros.provide("/ariac/start_competition", TRIGGER, lambda *_: STARTED_ALREADY)
            add_gantry(cell, ros, root="")
            self._actions.append(gantry_action(ros, cell, simulation.gantry.name))
        bodies = [f"people/{person.name}" for person in simulation.people]
        bodies += [f"machines/{name}" for name in vehicles]
        for body in bodies:
            self._actions += navigation_of(ros, cell, body, plain(body.partition("/")[2]))
        People(ros, cell, self._advance_by, self._reset)
        Control(ros, pace, partial(self._advance_by, 1 / POSES), self._reset)
        Entities(ros, cell)
        publish_map(ros, simulation.trial.floorplan)
        ros.report_omitted()
        self._executor = Executor(context=node.context)
        with redirect_stdout(StringIO()):  # rclpy prints that many actions may be inefficient
            self._executor.add_node(node)
            self._executor.spin_once(timeout_sec=0.0)
        self._enter(STARTED)
        for event in simulation.events:
            cell.signals["events"].send(event)
        for rate in (POSES, USUAL_RATE, DIAGNOSTICS):
            pace.every(1 / rate, partial(ros.publish_state, rate))
        pace.every(1 / USUAL_RATE, self._publish_feedback)
        domain = node.context.get_domain_id()
        notice(f"serving {node.get_fully_qualified_name()} in domain {domain}")

    def run(self) -> None:
        """Serve until the trial is over or stopped."""
        pace, look_at = self._pace, 0.0
        while not pace.over:
            delay = pace.delay() if self._runs else LONGEST_WAIT
            is_due = self._ros.end_turn()
            wait = 0.0 if is_due else min(max(delay, 0.0), LONGEST_WAIT)
            self._executor.spin_once(timeout_sec=wait)
            pace.catch_up(LONGEST_WAIT * pace.speed)
            if time.monotonic() > look_at:
                look_at = time.monotonic() + LONGEST_WAIT
                self._look()
            if self._runs and pace.give_up():
                self._ros.warn("speed", f"this machine is too slow for --speed {pace.speed:g}")
        self._cell.update()
        self._ros.publish_state(POSES)
        self._enter(ENDED)
        last = time.monotonic()
        if any(action.is_busy for action in self._actions):
            last += LAST_WAIT
        while time.monotonic() < last:
            self._executor.spin_once(timeout_sec=LONGEST_WAIT)
        pace.check()

    def _publish_feedback(self) -> None:
        for action in self._actions:
            action.publish()

    def _look(self) -> None:
        """React to publishers that have come or gone."""
        for vehicle in self._vehicles:
            vehicle.listen()
        if self._ros.node.count_publishers("/clock") > 1:
            self._ros.warn("/clock", "several publishers, because another simulator runs")

    def _reset(self) -> None:
        """Begin the run again, with another simulation."""
        at = self._cell.now
        self._enter(STARTED)
        self._cell.continue_with(self._restart())
        self._ros.notice(f"reset at t = {at:g} s: the clock starts again")
        self._ros.publish_state(POSES)

    @property
    def _runs(self) -> bool:
        """Whether time follows the wall clock."""
        return bool(self._pace.speed) and not self._pace.paused

    def _advance_by(self, seconds: float) -> bool:
        """Advance by seconds. Return False if time follows the wall clock, or the run is over."""
        if self._runs or self._pace.over:
            return False
        self._pace.step(seconds)
        return True
