"""How late odometry is, how soon goals and velocities take effect, and what a served trial costs.

    python benchmarks/ros2.py [--seconds S] [--repeats N]

Run it with the Python of ROS. The command `floorwalker ros2` runs in another process: a vehicle and
five people, odometry at 50 Hz, scans at 10 Hz. A message is late by the time from its publication
to its callback. A goal is accepted after the answer to its request. A velocity takes effect with
the first odometry of a moving vehicle. CPU is that of the server in the process table.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import rclpy
from geometry_msgs.msg import TwistStamped
from nav2_msgs.action import NavigateToPose
from nav_msgs.msg import Odometry
from people_msgs.msg import People
from rclpy.action import ActionClient
from sensor_msgs.msg import LaserScan

TRIAL = """
floorplan: warehouse
duration: 3600
rules: observe
people: [{name: person, count: 5, at: anywhere, personality: external}]
machines:
  bot: {kind: amr, at: [8.5, 10.0, 1.5708], size: [0.6, 0.5], controller: external}
"""


class Client:
    """Subscriber of odometry, scans and people, and sender of velocities and goals."""

    def __init__(self) -> None:
        self.node = rclpy.create_node("benchmark")
        self.late: list[float] = []
        self.speed = 0.0
        self.node.create_subscription(Odometry, "/odom", self._hear, 10)
        for kind, topic in ((LaserScan, "/scan"), (People, "/people")):
            self.node.create_subscription(kind, topic, lambda _: None, 10)
        self._velocities = self.node.create_publisher(TwistStamped, "/cmd_vel", 10)
        self._goals = ActionClient(self.node, NavigateToPose, "/bot/navigate_to_pose")

    def _hear(self, message: Odometry, info: Any) -> None:
        self.late.append(time.time() - info["source_timestamp"] / 1e9)
        self.speed = message.twist.twist.linear.x

    def until(self, holds: Callable[[], object]) -> None:
        """Spin until something holds."""
        while not holds():
            rclpy.spin_once(self.node, timeout_sec=0.1)

    def spend(self, seconds: float) -> None:
        """Spin for some seconds."""
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end)

    def ready(self) -> None:
        """Wait for the server."""
        self.until(lambda: self.late and self._goals.server_is_ready())
        self.spend(2.0)
        self.late.clear()

    def accepted(self) -> float:
        """Return the seconds until a goal is accepted, and cancel it."""
        goal = NavigateToPose.Goal()
        goal.pose.header.frame_id = "map"
        goal.pose.pose.position.x, goal.pose.pose.position.y = 8.5, 12.0
        begin = time.perf_counter()
        future = self._goals.send_goal_async(goal)
        self.until(future.done)
        taken = time.perf_counter() - begin
        cancelled = future.result().cancel_goal_async()
        self.until(cancelled.done)
        self.until(lambda: not self.speed)
        return taken

    def moves(self) -> float:
        """Return the seconds from a velocity to the odometry of a moving vehicle."""
        self.spend(1.0)
        self.until(lambda: not self.speed)
        message = TwistStamped()
        message.twist.angular.z = 0.3
        message.twist.linear.x = 0.1
        begin = time.perf_counter()
        self._velocities.publish(message)
        self.until(lambda: self.speed)
        return time.perf_counter() - begin

    def drive(self, seconds: float) -> None:
        """Drive in a circle."""
        message = TwistStamped()
        message.twist.linear.x, message.twist.angular.z = 0.1, 0.5
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._velocities.publish(message)
            self.spend(0.05)


def cpu(process: int) -> float:
    """Return the CPU time (s) of a process until now."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def share(process: int, spend: Callable[[float], None], seconds: float) -> float:
    """Return the CPU time of a process as a share of a core while time is spent."""
    before, begin = cpu(process), time.monotonic()
    spend(seconds)
    return (cpu(process) - before) / (time.monotonic() - begin)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--repeats", type=int, default=20)
    options = parser.parse_args()
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ.setdefault("ROS_DOMAIN_ID", "93")
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "cell.trial.yaml").write_text(TRIAL)
        words = [sys.executable, "-m", "floorwalker", "ros2", "cell.trial.yaml", "--out", "run"]
        server = subprocess.Popen(words, cwd=folder, stdout=subprocess.DEVNULL)
        rclpy.init()
        client = Client()
        client.ready()
        idle = share(server.pid, client.spend, options.seconds)
        late = sorted(client.late)
        goals = sorted(client.accepted() for _ in range(options.repeats))
        motions = sorted(client.moves() for _ in range(options.repeats))
        driving = share(server.pid, client.drive, options.seconds)
        server.terminate()
        server.wait()
    for name, values in (
        ("odometry late", late),
        ("goal accepted", goals),
        ("velocity to moving odometry", motions),
    ):
        median, most = statistics.median(values), values[int(0.95 * len(values))]
        print(f"{name}: median {1e3 * median:.1f} ms, 95 % {1e3 * most:.1f} ms")
    print(f"CPU at rest: {idle:.1%} of a core, while driving: {driving:.1%}")
    print(f"load of the machine: {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
