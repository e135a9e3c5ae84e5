"""Clients with rclpy, each a function that returns what it has seen: client.py FUNCTION JSON."""

import json
import math
import sys
import time

import rclpy
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from rclpy.qos import DurabilityPolicy, QoSProfile

HANG = 120.0
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Client:
    """A node with the last message of each topic that it listens to."""

    def __init__(self):
        self.node = rclpy.create_node("client")
        self.last = {}

    def listen(self, topic, type_, qos=10):
        self.node.create_subscription(type_, topic, lambda m: self.last.update({topic: m}), qos)

    def until(self, holds):
        """Spin until `holds` returns something, and return it."""
        hangs_at = time.monotonic() + HANG
        while not (answer := holds()):
            assert time.monotonic() < hangs_at, self.node.get_topic_names_and_types()
            rclpy.spin_once(self.node, timeout_sec=0.05)
        return answer

    def wait(self, future):
        self.until(future.done)
        return future.result()

    def heard(self, topic, type_, qos=10):
        """Return the next message of a topic."""
        self.listen(topic, type_, qos)
        self.last.pop(topic, None)
        return self.until(lambda: self.last.get(topic))

    def call(self, type_, name, **fields):
        client = self.node.create_client(type_, name)
        self.until(client.service_is_ready)
        return self.wait(client.call_async(type_.Request(**fields)))


def topics(names):
    """The types of topics, once they are there."""
    client = Client()

    def there():
        types = dict(client.node.get_topic_names_and_types())
        return types if set(names) <= types.keys() else None

    return client.until(there)


def drive(speed):
    """Drive with TwistStamped until the vehicle stops; the odometry, scan and map at the end."""
    from nav_msgs.msg import OccupancyGrid
    from sensor_msgs.msg import LaserScan

    client = Client()
    grid = client.heard("/map", OccupancyGrid, LATCHED)
    publisher = client.node.create_publisher(TwistStamped, "/cmd_vel", 10)
    client.listen("/odom", Odometry)
    client.listen("/scan", LaserScan)

    moved = []

    def stopped():
        message = TwistStamped()
        message.twist.linear.x = speed
        publisher.publish(message)
        if odometry := client.last.pop("/odom", None):
            moved.append(odometry.twist.twist.linear.x > 0)
        return any(moved) and not any(moved[-50:])

    client.until(stopped)
    odometry = client.heard("/odom", Odometry).pose.pose
    scan = client.heard("/scan", LaserScan)
    width, origin = grid.info.width, grid.info.origin.position
    column = int((8.0 - origin.x) / grid.info.resolution)
    row = int((6.5 - origin.y) / grid.info.resolution)
    return {
        "odom": [odometry.position.x, odometry.position.y, _heading(odometry)],
        "ranges": [*scan.ranges],
        "first": scan.angle_min,
        "step": scan.angle_increment,
        "rack": grid.data[row * width + column + 20],
        "free": grid.data[row * width + column - 40],
    }


def _heading(pose):
    return 2 * math.atan2(pose.orientation.z, pose.orientation.w)


def navigate(name, x, y, heading=0.0, cancel_after=None):
    """Send somebody to a place: the outcome, the feedback, and where it ends."""
    from nav2_msgs.action import NavigateToPose

    goal = NavigateToPose.Goal(pose=_pose(x, y, heading))
    answer, feedback = _carried_out(NavigateToPose, f"/{name}/navigate_to_pose", goal, cancel_after)
    if feedback:
        at = feedback[-1].current_pose.pose.position
        answer["distances"] = [one.distance_remaining for one in feedback]
        answer["times"] = [one.estimated_time_remaining.sec for one in feedback]
        answer["end"] = [at.x, at.y]
    return answer


def go_through(name, poses, cancel_after=None):
    """Send somebody through poses: the outcome, and the feedback about the poses left."""
    from nav2_msgs.action import NavigateThroughPoses

    goal = NavigateThroughPoses.Goal()
    goal.poses.goals = [_pose(*pose) for pose in poses]
    action = f"/{name}/navigate_through_poses"
    answer, feedback = _carried_out(NavigateThroughPoses, action, goal, cancel_after)
    answer["left"] = [one.number_of_poses_remaining for one in feedback]
    answer["places"] = [
        [one.current_pose.pose.position.x, one.current_pose.pose.position.y] for one in feedback
    ]
    return answer


def follow(name, points, cancel_after=None):
    """Let somebody follow a path: the outcome, and the feedback about distance and speed."""
    from nav2_msgs.action import FollowPath

    goal = FollowPath.Goal()
    goal.path.header.frame_id = "map"
    goal.path.poses = [_pose(x, y, 0.0) for x, y in points]
    answer, feedback = _carried_out(FollowPath, f"/{name}/follow_path", goal, cancel_after)
    answer["distances"] = [one.distance_to_goal for one in feedback]
    answer["speeds"] = [one.speed for one in feedback]
    return answer


def _pose(x, y, heading=0.0):
    pose = PoseStamped()
    pose.header.frame_id = "map"
    pose.pose.position.x, pose.pose.position.y = float(x), float(y)
    pose.pose.orientation.z = math.sin(heading / 2)
    pose.pose.orientation.w = math.cos(heading / 2)
    return pose


def _carried_out(type_, name, goal, cancel_after):
    """The outcome of a goal, which is cancelled after so many messages of feedback, and these."""
    client, feedback = Client(), []
    action = ActionClient(client.node, type_, name)
    client.until(action.server_is_ready)
    handle = client.wait(
        action.send_goal_async(goal, feedback_callback=lambda m: feedback.append(m.feedback))
    )
    if not handle.accepted:
        return {"accepted": False}, []
    if cancel_after is not None:
        client.until(lambda: len(feedback) >= cancel_after)
        client.wait(handle.cancel_goal_async())
    answer = client.wait(handle.get_result_async())
    status = {
        GoalStatus.STATUS_SUCCEEDED: "succeeded",
        GoalStatus.STATUS_CANCELED: "cancelled",
        GoalStatus.STATUS_ABORTED: "aborted",
    }[answer.status]
    error = [answer.result.error_code, answer.result.error_msg]
    return {"accepted": True, "status": status, "error": error}, feedback


def step(count, times):
    """Let the simulation make steps, until it is over; the clock at the end."""
    from simulation_interfaces.srv import StepSimulation

    client = Client()
    results = []
    stepper = client.node.create_client(StepSimulation, "/step_simulation")
    client.until(stepper.service_is_ready)
    for _ in range(times):
        answer = client.wait(stepper.call_async(StepSimulation.Request(steps=count)))
        results.append(answer.result.result)
    return results


def trajectory(positions, seconds):
    """Move the gantry by an action: the status, the feedback, and the joints at the end."""
    from control_msgs.action import FollowJointTrajectory
    from sensor_msgs.msg import JointState
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    client = Client()
    names = ["gantry_x_axis_joint", "gantry_y_axis_joint", "gantry_rotation_joint"]
    action = ActionClient(
        client.node, FollowJointTrajectory, "/gantry_controller/follow_joint_trajectory"
    )
    client.until(action.server_is_ready)
    point = JointTrajectoryPoint(positions=positions)
    point.time_from_start.sec = seconds
    goal = FollowJointTrajectory.Goal()
    goal.trajectory = JointTrajectory(joint_names=names, points=[point])
    handle = client.wait(action.send_goal_async(goal))
    if not handle.accepted:
        return {"accepted": False}
    result = client.wait(handle.get_result_async())
    joints = client.heard("/joint_states", JointState)
    return {
        "accepted": True,
        "status": result.status,
        "code": result.result.error_code,
        "joints": [*joints.position],
    }


def agents(seconds):
    """Ask for people as a plugin of another simulator does, once per second."""
    from hunav_msgs.srv import ComputeAgents, GetAgents

    client = Client()
    seen = [_places(client.call(GetAgents, "/get_agents").agents)]
    compute = client.node.create_client(ComputeAgents, "/compute_agents")
    client.until(compute.service_is_ready)
    for second in range(seconds + 1):
        request = ComputeAgents.Request()
        request.current_agents.header.stamp.sec = 100 + second
        seen.append(_places(client.wait(compute.call_async(request)).updated_agents))
    return seen


def _places(message):
    return {
        agent.name: [agent.position.position.x, agent.position.position.y]
        for agent in message.agents
    }


def listened():
    """The monitor, people, markers and first event, as a viewer gets them."""
    from diagnostic_msgs.msg import DiagnosticArray
    from people_msgs.msg import People
    from std_msgs.msg import String
    from tf2_msgs.msg import TFMessage
    from visualization_msgs.msg import MarkerArray

    client = Client()
    client.listen("/events", String)
    people = client.heard("/people", People)
    frames = set()
    client.listen("/tf", TFMessage)

    def all_frames():
        message = client.last.pop("/tf", None)
        frames.update((t.header.frame_id, t.child_frame_id) for t in message.transforms if message)
        return len(frames) >= 4

    client.until(lambda: "/tf" in client.last and all_frames())
    return {
        "people": {one.name: [one.position.x, one.position.y] for one in people.people},
        "frames": sorted(frames),
        "monitor": [
            {"name": status.name, **{value.key: float(value.value) for value in status.values}}
            for status in client.heard("/diagnostics", DiagnosticArray).status
        ],
        "markers": len(client.heard("/markers", MarkerArray, LATCHED).markers),
    }


def flood():
    """Send a vehicle what it must not follow, and then a good command, until it moves."""
    from geometry_msgs.msg import PoseWithCovarianceStamped

    client = Client()
    publisher = client.node.create_publisher(Twist, "/cmd_vel", 10)
    located = client.node.create_publisher(PoseWithCovarianceStamped, "/initialpose", 10)
    client.listen("/odom", Odometry)
    client.until(lambda: client.node.count_subscribers("/cmd_vel") and "/odom" in client.last)
    bad, good = Twist(), Twist()
    bad.linear.x, good.linear.x = math.nan, 0.3
    pose = PoseWithCovarianceStamped()
    pose.header.frame_id = "odom"
    located.publish(pose)

    def moving():
        publisher.publish(bad)
        publisher.publish(good)
        return client.last["/odom"].twist.twist.linear.x > 0.2

    return client.until(moving)


if __name__ == "__main__":
    rclpy.init()
    answer = globals()[sys.argv[1]](**json.loads(sys.argv[2]))
    print(json.dumps(answer))
    rclpy.shutdown()
