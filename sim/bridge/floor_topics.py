"""Topics of all people and machines, with the names of `floorwalker ros2`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

from ..cell import Cell, CellCommand, CellTask, Pose, Scan, Signal, Velocity
from ..cell.names import plain, prefix_of
from ..cell.signals import SCANS
from ..competition import Values, take
from ..competition.messages import about_z, seconds, vector
from .exchange import Exchange, Topic

STRING, GOAL = "std_msgs/String", "geometry_msgs/PoseStamped"


class FloorTopics:
    """Publishes poses, scans and states, and starts tasks at goals that clients publish."""

    def __init__(self, cell: Cell, exchange: Exchange) -> None:
        self._cell = cell
        self._exchange = exchange
        self._odometry: list[tuple[Topic, str, Signal, Signal]] = []
        self._scans: list[tuple[Topic, str, Signal]] = []
        self._people = exchange.advertise("/people_poses", "geometry_msgs/PoseArray")
        machines = (f"machines/{name}" for name in cell.simulation.machines)
        for body in (*machines, *self._names_of_people()):
            prefix = f"/{prefix_of(cell.simulation, body.partition('/')[2])}"
            self._add_signals(body, prefix)
            self._add_inputs(body, prefix)

    def topics_of(self, person: str) -> tuple[frozenset[str], frozenset[str]]:
        """Return the topics that an agent of a person subscribes to, and publishes on."""
        prefix = f"/{plain(person)}/"
        return frozenset({f"{prefix}percept"}), frozenset({f"{prefix}goal_pose", f"{prefix}action"})

    def publish(self, now: float) -> None:
        """Publish the state at `now` (s)."""
        exchange = self._exchange
        if self._people.is_needed:
            poses = (self._cell.signals[f"{name}/pose"].read() for name in self._names_of_people())
            message = {"header": _header(now), "poses": [_pose(one) for one in poses if one]}
            exchange.publish(self._people, message)
        for topic, frame, pose, velocity in self._odometry:
            if topic.is_needed and (here := pose.read()) is not None:
                exchange.publish(topic, _odometry(now, frame, here, velocity.read()))
        for topic, frame, scan in self._scans:
            if topic.is_needed:
                exchange.publish(topic, _laser_scan(now, frame, scan.read()))

    def _names_of_people(self) -> Iterator[str]:
        return (f"people/{person.name}" for person in self._cell.simulation.people)

    def _add_signals(self, body: str, prefix: str) -> None:
        signals, exchange = self._cell.signals, self._exchange
        topic = exchange.advertise(f"{prefix}odom", "nav_msgs/Odometry")
        frame = f"{prefix[1:]}base_link"
        pose, velocity = signals[f"{body}/pose"], signals[f"{body}/velocity"]
        self._odometry.append((topic, frame, pose, velocity))
        if (scan := signals.get(f"{body}/scan")) is not None:
            topic = exchange.advertise(f"{prefix}scan", "sensor_msgs/LaserScan")
            self._scans.append((topic, frame, scan))
        for name in ("state", "percept"):
            if (signal := signals.get(f"{body}/{name}")) is not None:
                topic = exchange.advertise(f"{prefix}{name}", STRING, latched=int(signal.latched))
                send = partial(self._send_text, topic)
                signal.watch(send)
                if signal.latched:
                    send(signal.read())

    def _add_inputs(self, body: str, prefix: str) -> None:
        commands, exchange = self._cell.commands, self._exchange
        if (twist := commands.get(f"{body}/twist")) is not None:
            for name, type_ in (("cmd_vel", "Twist"), ("cmd_vel_stamped", "TwistStamped")):
                topic = f"{prefix}{name}"
                exchange.listen(topic, f"geometry_msgs/{type_}", partial(_drive, topic, twist))
        if (act := commands.get(f"{body}/act")) is not None:
            topic = f"{prefix}action"
            exchange.listen(topic, STRING, partial(_act, topic, act))
        if (task := self._cell.tasks.get(f"{body}/go_to")) is not None:
            topic = f"{prefix}goal_pose"
            results = exchange.advertise(f"{prefix}goal_result", STRING)
            exchange.listen(topic, GOAL, partial(self._go, topic, task, results))

    def _go(
        self, topic: str, task: CellTask, results: Topic, message: Values, source: str = ""
    ) -> None:
        """Start a task at a goal, and publish its result."""
        position, turn = message["pose"]["position"], message["pose"]["orientation"]
        heading = 2 * math.atan2(turn["z"], turn["w"]) if any(turn.values()) else 0.0
        running = take(topic, task, Pose(position["x"], position["y"], heading), source)
        running.on_end(partial(self._send_text, results))

    def _send_text(self, topic: Topic, text: str) -> None:
        self._exchange.publish(topic, {"data": text})


def _drive(topic: str, twist: CellCommand, message: Values, source: str = "") -> None:
    velocity = message.get("twist", message)
    linear, turn = velocity["linear"], velocity["angular"]["z"]
    take(topic, twist, (linear["x"], linear["y"], turn), source)


def _act(topic: str, act: CellCommand, message: Values, source: str = "") -> None:
    take(topic, act, message["data"], source)


def _header(t: float, frame: str = "world") -> Values:
    return {"stamp": seconds(t), "frame_id": frame}


def _pose(pose: Pose) -> Values:
    return {"position": vector((pose.x, pose.y, 0.0)), "orientation": about_z(pose.heading)}


def _odometry(t: float, frame: str, pose: Pose, velocity: Velocity) -> Values:
    """Return nav_msgs/Odometry, with the velocity in the frame of the body."""
    seen = velocity.seen_at(pose.heading)
    twist = {"linear": vector((seen.x, seen.y, 0.0)), "angular": vector((0.0, 0.0, seen.turn))}
    return {
        "header": _header(t),
        "child_frame_id": frame,
        "pose": {"pose": _pose(pose), "covariance": [0.0] * 36},
        "twist": {"twist": twist, "covariance": [0.0] * 36},
    }


def _laser_scan(t: float, frame: str, scan: Scan) -> Values:
    """Return sensor_msgs/LaserScan. JSON has no infinity, so it is the range where nothing is."""
    return {
        "header": _header(t, frame),
        "angle_min": scan.first,
        "angle_max": scan.first + math.tau - scan.step,
        "angle_increment": scan.step,
        "time_increment": 0.0,
        "scan_time": 1 / SCANS,
        "range_min": 0.0,
        "range_max": scan.reach,
        "ranges": scan.distances.tolist(),
        "intensities": [],
    }
