"""Trial as topics and services of ARIAC 2023, with topics of all people and machines."""

from __future__ import annotations

from collections.abc import Callable

from floorplan import UserError

from ..cell import Cell, Pace, Pose
from ..competition import CompetitionTopics, Values, add_gantry
from ..competition.human_topics import COMMANDS, START
from ..competition.messages import seconds, transform
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
        self.follow(cell.pace)
        for event in simulation.events:
            cell.signals["events"].send(event)
        self.publish()

    def follow(self, pace: Pace) -> None:
        """Publish the state at the ticks of a pace, and before each decision."""
        self.cell.follow(pace)
        pace.after.insert(0, self._publish_before_decision)
        pace.every(1 / RATE, self.publish)

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

    def _named_frames(self) -> list[tuple[str, Body, float]]:
        """Return the frames of person, gantry, AGVs and all others, with heights in metres."""
        simulation = self.simulation
        frames = [(f"{agv.lane.name}_base", agv.body, 0.0) for agv in simulation.agvs]
        if simulation.gantry is not None:
            height = simulation.gantry.gantry.rail_height
            frames.insert(0, ("torso_base", simulation.gantry.body, height))
        if self.person is not None:
            frames.insert(0, ("base_link", self.person.walker.body, 0.0))
        listed = {body for _, body, _ in frames}
        others = [body for body in simulation.bodies if body not in listed]
        return [*frames, *((f"{body.name}/base_link", body, 0.0) for body in others)]

    def _transforms(self) -> Values:
        """Return tf2_msgs/TFMessage from the world to all frames."""
        return {
            "transforms": [
                transform(self.now, "world", name, Pose.of(body.state), height)
                for name, body, height in self._frames
            ]
        }
