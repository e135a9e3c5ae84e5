"""Trial as topics and services of ARIAC 2023, with topics of all people and machines."""

from __future__ import annotations

from collections.abc import Callable

from floorplan import UserError

from ..cell import Cell, Pose
from ..competition import CompetitionTopics, Values, add_gantry
from ..competition.human_topics import COMMANDS, START
from ..competition.messages import WORLD, seconds, transform
from ..core.body import Body
from ..core.recorder import Listener
from ..people.minds import Outside
from ..people.programs import EXTERNAL
from ..simulation import Simulation
from ..trials.trial import Trial
from .body_topics import add_body_topics, topics_of
from .exchange import Exchange

RATE = 10.0
"""Hz, in simulated time. Rate at which the state is published."""


class BridgeError(UserError):
    """Trial that cannot be bridged, or invalid setting of a bridge."""


class Workcell:
    """Simulation of a trial, published to an exchange and commanded from there.

    Parameters
    ----------
    trial : Trial
        The trial.
    exchange : Exchange
        Topics and services.
    *listeners : Listener
        Listeners of the simulation.

    Attributes
    ----------
    simulation : Simulation
        The simulation, which is started.
    cell : Cell
        Signals, commands and tasks of the simulation.
    competition : CompetitionTopics
        Topics and services of the competition.
    person : Person or None
        Person of the competition's topics.
    external : tuple of Person
        People who are driven from outside.
    agents : dict of str to tuple
        Topics that the agent of each external person subscribes to, and publishes on.
    needs_controller : bool
        Whether clients control the gantry.
    notice : callable
        Function for lines that the user should read.
    repeats : bool
        Whether a violation is published with every state until the agent has answered it.
    """

    def __init__(self, trial: Trial, exchange: Exchange, *listeners: Listener) -> None:
        self.repeats = False
        self.notice: Callable[[str], None] = lambda text: None
        self.simulation = simulation = Simulation(trial, *listeners)
        for person in simulation.people:
            person.walker.prepare()  # so that clients need not wait for the planner later
        self._exchange = exchange
        self._published_at = -1.0
        self.cell = cell = Cell(simulation, notice=lambda text: self.notice(text))
        exchange.advertise("/clock", "rosgraph_msgs/Clock", lambda: {"clock": seconds(self.now)})
        self.competition = CompetitionTopics(cell, exchange)
        self.person = self.competition.person
        self.external = tuple(p for p in simulation.people if isinstance(p.mind, Outside))
        has_gantry = simulation.gantry is not None
        self.needs_controller = has_gantry and trial.gantry.controller == EXTERNAL
        add_gantry(cell, exchange)
        add_body_topics(cell, exchange)
        self.agents = {one.name: topics_of(one.name) for one in self.external}
        if self.person in self.external:
            heard, commanded = self.agents[self.person.name]
            self.agents[self.person.name] = heard | {START}, commanded | COMMANDS.keys()
        self._frames = self._named_frames()
        exchange.advertise("/tf", "tf2_msgs/TFMessage", self._transforms)
        cell.pace.after.insert(0, self._publish_before_decision)
        cell.pace.every(1 / RATE, self.publish)
        for event in simulation.events:
            cell.signals["events"].send(event)
        self.publish()

    @property
    def now(self) -> float:
        """Simulated time in seconds."""
        return self.cell.now

    def publish(self) -> None:
        """Publish the present state, once at each time."""
        if self.now == self._published_at:
            return
        self._published_at = self.now
        self._exchange.publish_state()
        if self.repeats:
            self.competition.repeat()

    def _publish_before_decision(self) -> None:
        if self.cell.has_decision:
            self.publish()

    def _named_frames(self) -> dict[Body, tuple[str, float]]:
        """Return name and height (m) of the frame of each body."""
        frames, gantry = dict[Body, tuple[str, float]](), self.simulation.gantry
        if self.person is not None:
            frames[self.person.body] = ("base_link", 0.0)
        if gantry is not None:
            frames[gantry.body] = ("torso_base", gantry.gantry.rail_height)
        for agv in self.simulation.agvs:
            frames[agv.body] = (f"{agv.lane.name}_base", 0.0)
        for body in self.simulation.bodies:
            frames.setdefault(body, (f"{body.name}/base_link", 0.0))
        return frames

    def _transforms(self) -> Values:
        """Return tf2_msgs/TFMessage from the world to all frames."""
        return {
            "transforms": [
                transform(self.now, WORLD, name, Pose.of(body.state), height)
                for body, (name, height) in self._frames.items()
            ]
        }
