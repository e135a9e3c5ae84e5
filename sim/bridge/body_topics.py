"""Topics of all people and machines, with the names of `floorwalker ros2`."""

from __future__ import annotations

from functools import partial

from ..cell import Cell, CellTask, Pose, Signal
from ..competition.messages import (
    WORLD,
    header,
    laser_scan,
    odometry,
    pose_message,
    stamped_pose_of,
)
from ..competition.transport import Values, plain, prefix_of
from ..exports.scene import ROOT_FRAME
from .exchange import Exchange, Topic

STRING = "std_msgs/String"


def add_body_topics(cell: Cell, exchange: Exchange) -> None:
    """Add the poses, scans and states of all people and machines, and topics of their goals."""
    people = [f"people/{person.name}" for person in cell.simulation.people]
    poses = [cell.signals[f"{person}/pose"] for person in people]
    exchange.advertise(
        "/people_poses",
        "geometry_msgs/PoseArray",
        lambda: {
            "header": header(cell.now),
            "poses": [pose_message(pose) for one in poses if (pose := one.read())],
        },
    )
    for body in (*(f"machines/{name}" for name in cell.simulation.machines), *people):
        prefix = f"/{prefix_of(cell.simulation, body.partition('/')[2])}"
        _add_signals(cell, exchange, body, prefix)
        _add_inputs(cell, exchange, body, prefix)


def topics_of(person: str) -> tuple[frozenset[str], frozenset[str]]:
    """Return the topics that an agent of a person subscribes to, and publishes on."""
    prefix = f"/{plain(person)}/"
    return frozenset({f"{prefix}percept"}), frozenset({f"{prefix}goal_pose", f"{prefix}action"})


def _add_signals(cell: Cell, exchange: Exchange, body: str, prefix: str) -> None:
    signals, frame = cell.signals, f"{prefix[1:]}base_link"
    odometry = partial(_odometry, cell, frame, signals[f"{body}/pose"], signals[f"{body}/velocity"])
    exchange.advertise(f"{prefix}odom", "nav_msgs/Odometry", odometry)
    if (scan := signals.get(f"{body}/scan")) is not None:
        ranges = partial(_laser_scan, cell, frame, scan)
        exchange.advertise(f"{prefix}scan", "sensor_msgs/LaserScan", ranges)
    for name in ("state", "percept"):
        if (signal := signals.get(f"{body}/{name}")) is not None:
            topic = exchange.advertise(f"{prefix}{name}", STRING, latched=int(signal.latched))
            send = partial(_send_text, exchange, topic)
            signal.watch(send)
            if signal.latched:
                send(signal.read())


def _add_inputs(cell: Cell, exchange: Exchange, body: str, prefix: str) -> None:
    if (twist := cell.commands.get(f"{body}/twist")) is not None:

        def drive(message: Values, source: str) -> None:
            velocity = message.get("twist", message)
            linear, turn = velocity["linear"], velocity["angular"]["z"]
            twist.take((linear["x"], linear["y"], turn), source)

        exchange.listen(f"{prefix}cmd_vel", "geometry_msgs/Twist", drive)
        exchange.listen(f"{prefix}cmd_vel_stamped", "geometry_msgs/TwistStamped", drive)
    if (act := cell.commands.get(f"{body}/act")) is not None:
        exchange.listen(f"{prefix}action", STRING, lambda text, who: act.take(text["data"], who))
    if (task := cell.tasks.get(f"{body}/go_to")) is not None:
        results = exchange.advertise(f"{prefix}goal_result", STRING)
        go = partial(_go, task, partial(_send_text, exchange, results))
        exchange.listen(f"{prefix}goal_pose", "geometry_msgs/PoseStamped", go)


def _go(task: CellTask, ended: partial[None], message: Values, source: str) -> None:
    """Start a task at a goal, and publish its result."""
    task.start(stamped_pose_of(message, floor=(WORLD, ROOT_FRAME)), source).on_end(ended)


def _send_text(exchange: Exchange, topic: Topic, text: str) -> None:
    exchange.publish(topic, {"data": text})


def _odometry(cell: Cell, frame: str, pose: Signal, velocity: Signal) -> Values | None:
    """Return nav_msgs/Odometry of a body that is on the floor."""
    here: Pose | None = pose.read()
    if here is None:
        return None
    return odometry(cell.now, WORLD, frame, here, velocity.read().seen_at(here.heading))


def _laser_scan(cell: Cell, frame: str, signal: Signal) -> Values:
    # JSON has no infinity, so a range is the maximum where nothing is.
    return laser_scan(cell.now, frame, signal.read())
