"""A trial's simulation as topics and services of ROS."""

from __future__ import annotations

from collections.abc import Callable

from simpy.core import StopSimulation

from floorplan import UserError

from ..core.body import Body
from ..core.clock import Turn
from ..core.recorder import Event, Listener
from ..people.minds import Outside
from ..people.programs import EXTERNAL
from ..simulation import Simulation
from ..trials.trial import Trial
from .exchange import Exchange, RefusedError
from .human_topics import HumanTopics
from .machine_topics import AgvTopics, GantryTopics
from .readings import human_state, order_message, seconds, transforms

READY, STARTED, ANNOUNCED, ENDED = 1, 2, 3, 4
"""Phases of ariac_msgs/CompetitionState; ANNOUNCED: started, and all orders are announced."""

MOST_COMMANDS = 300
"""How many commands are taken at one instant of simulated time."""

_MOST_ORDERS = 1000


class BridgeError(UserError):
    """A trial that can't be bridged, or a wrong setting of a bridge."""


class Workcell(Listener):
    """A trial's simulation, published to an exchange and commanded from there.

    `outside` is the mind of the person who is driven from outside, if the trial has one.
    `catch_up()` brings simulated time up to the present before a command is carried out, and
    `is_open()` tells whether commands are still taken.
    """

    def __init__(self, trial: Trial, exchange: Exchange, *listeners: Listener) -> None:
        driven = driven_person(trial)
        self.catch_up: Callable[[], None] = lambda: None
        self.is_open: Callable[[], bool] = lambda: True
        self.repeats = False
        """True to publish a violation with every state until the agent has answered it."""
        self.human: HumanTopics | None = None
        self._exchange = exchange
        self._orders = exchange.advertise("/ariac/orders", "ariac_msgs/Order", latched=_MOST_ORDERS)
        self._phase = exchange.advertise(
            "/ariac/competition_state", "ariac_msgs/CompetitionState", latched=1
        )
        orders = trial.workload.orders if trial.workload else ()
        self._unannounced = {order.id: order for order in orders}
        self.simulation = simulation = Simulation(trial, self, *listeners)
        for person in simulation.people:
            # So that no client has to wait for the planner once time goes on.
            person.walker.prepare()
        self.person = None if driven is None else simulation.people[driven]
        self._commands = (simulation.clock.now, 0)
        self._clock = exchange.advertise("/clock", "rosgraph_msgs/Clock")
        self._tf = exchange.advertise("/tf", "tf2_msgs/TFMessage")
        self._state = exchange.advertise("/ariac_human/state", "ariac_msgs/HumanState")
        self._agvs = AgvTopics(simulation.agvs, exchange, self.admit)
        self._gantry: GantryTopics | None = None
        if simulation.gantry is not None:
            is_driven = trial.gantry.controller == EXTERNAL
            self._gantry = GantryTopics(simulation.gantry, exchange, self.admit, driven=is_driven)
        self.outside: Outside | None = None
        self._asked = False
        if self.person is not None:
            self.human = HumanTopics(self.person, simulation, exchange, self.admit)
            self.outside = self.human.outside
        if self.outside is not None:
            self.outside.called = self._ask
        simulation.start()
        self._frames = self._named_frames()
        self.enter(READY)
        self.publish()

    @property
    def now(self) -> float:
        """The simulated time, seconds."""
        return self.simulation.clock.now

    def advance(self, until: float) -> bool:
        """Go on to `until` (seconds), or until the trial is over.

        Stop as soon as the person outside has something to decide on, and then return True; the
        percepts wait for `publish_percepts`.
        """
        clock = self.simulation.clock
        until = min(until, self.simulation.trial.duration)
        clock.begin_moment()
        try:
            while not self._asked and not self.simulation.over and clock.peek() < until:
                clock.step()
            if not self._asked and not self.simulation.over and clock.now < until:
                # Before all else at that instant, which is left for the next call.
                arrival = clock.at(until, Turn.VIOLATION)
                while not arrival.processed:
                    clock.step()
        except StopSimulation:
            pass  # the trial has come to its end
        return self._asked

    def admit(self, command: str) -> None:
        """Admit a command at the present time.

        `RefusedError` where the run is over, or where there are too many at once.
        """
        if self.is_open():
            self.catch_up()
        if not self.is_open():
            raise RefusedError(f"{command}: the run is over")
        since, count = self._commands
        self._commands = (self.now, count + 1 if self.now == since else 1)
        if self._commands[1] > MOST_COMMANDS:
            raise RefusedError(
                f"{command}: more than {MOST_COMMANDS} commands at t = {self.now:g} s; not done"
            )

    def publish_percepts(self) -> None:
        """Publish what the person outside has perceived since the last time."""
        self._asked = False
        if self.outside is not None and self.human is not None:
            for percept in self.outside.take():
                self.human.publish(percept.functor)

    def publish(self) -> None:
        """Publish the present state."""
        exchange, simulation, now = self._exchange, self.simulation, self.now
        exchange.publish(self._clock, {"clock": seconds(now)})
        if self._state.is_needed and self.person is not None:
            gantry = simulation.gantry
            robot = gantry.state if gantry else None
            height = gantry.gantry.rail_height if gantry else 0.0
            exchange.publish(self._state, human_state(self.person.walker.body.state, robot, height))
        if self.repeats and self.human is not None:
            self.human.repeat()
        self._agvs.publish()
        if self._gantry is not None:
            self._gantry.publish(now)
        if self._tf.is_needed:
            exchange.publish(self._tf, transforms(now, self._frames))

    def enter(self, phase: int) -> None:
        """Publish that the competition enters a phase."""
        self._exchange.publish(self._phase, {"competition_state": phase})

    def event(self, event: Event) -> None:
        """Publish orders as they are announced, and the percepts of a person."""
        if event["kind"] == "order_announced":
            order = self._unannounced.pop(event["order"])
            self._exchange.publish(self._orders, order_message(order))
            if not self._unannounced:
                self.enter(ANNOUNCED)
        if self.human is not None:
            self.human.event(event)

    def _ask(self) -> None:
        self._asked = True

    def _named_frames(self) -> list[tuple[str, Body, float]]:
        """The frames of the competition: the person's, the gantry's and the AGVs'; heights in m."""
        simulation = self.simulation
        frames = [(f"{agv.lane.name}_base", agv.body, 0.0) for agv in simulation.agvs]
        if simulation.gantry is not None:
            height = simulation.gantry.gantry.rail_height
            frames.insert(0, ("torso_base", simulation.gantry.body, height))
        if self.person is not None:
            frames.insert(0, ("base_link", self.person.walker.body, 0.0))
        return frames


def driven_person(trial: Trial) -> int | None:
    """Return the index of the person of the topics: the one driven from outside, or the first."""
    external = [k for k, person in enumerate(trial.people) if person.personality == EXTERNAL]
    if len(external) > 1:
        names = ", ".join(trial.people[k].name for k in external)
        raise BridgeError(
            f"{trial.name}: a bridge has the topics of one person, and {names} are external;"
            " give all but one of them a personality"
        )
    return external[0] if external else (0 if trial.people else None)
