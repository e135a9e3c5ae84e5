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
    answer["states"] = [[s.waypoint_status for s in one.waypoint_statuses] for one in feedback]
    return answer


def follow_waypoints(name, poses):
    """Send somebody to waypoints: the outcome, and the feedback about the current one."""
    from nav2_msgs.action import FollowWaypoints

    goal = FollowWaypoints.Goal(poses=[_pose(*pose) for pose in poses])
    answer, feedback = _carried_out(FollowWaypoints, f"/{name}/follow_waypoints", goal, None)
    answer["current"] = [one.current_waypoint for one in feedback]
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
    error, waypoints = [answer.result.error_code, answer.result.error_msg], []
    for field in ("waypoint_statuses", "missed_waypoints"):
        for one in getattr(answer.result, field, ()):
            at = one.waypoint_pose.pose.position
            waypoints.append([one.waypoint_index, one.waypoint_status, [at.x, at.y]])
    outcome = {"accepted": True, "status": status, "error": error, "waypoints": waypoints}
    return outcome, feedback


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


def read_simulation(radius):
    """What simulation_interfaces answer about a hall with a person and a vehicle."""
    from geometry_msgs.msg import Vector3
    from simulation_interfaces import srv
    from simulation_interfaces.msg import Bounds, EntityCategory, EntityFilters, TagsFilter

    client = Client()

    def call(name, **fields):
        service = "".join(f"_{c.lower()}" if c.isupper() else c for c in name)[1:]
        return client.call(getattr(srv, name), f"/{service}", **fields)

    def entities(**filters):
        answer = call("GetEntities", filters=EntityFilters(**filters))
        return [answer.result.result, *answer.entities]

    sphere = Bounds(type=Bounds.TYPE_SPHERE, points=[Vector3(x=6.0, y=4.0), Vector3(x=radius)])
    box = Bounds(type=Bounds.TYPE_BOX, points=[Vector3(x=5.0, y=8.0, z=2.0), Vector3(y=6.0)])
    robots = [EntityCategory(category=EntityCategory.CATEGORY_ROBOT)]
    states = call("GetEntitiesStates", filters=EntityFilters(filter="ann"))
    info, bounds = (call(name, entity="bot") for name in ("GetEntityInfo", "GetEntityBounds"))
    poses = call("GetNamedPoses", tags=TagsFilter(tags=["station"]))
    features = call("GetSimulatorFeatures").features
    return {
        "all": entities(),
        "named": entities(filter="^b"),
        "bad": entities(filter="("),
        "robots": entities(categories=robots),
        "people": entities(tags=TagsFilter(tags=["person", "amr"], filter_mode=0)),
        "both": entities(tags=TagsFilter(tags=["person", "amr"], filter_mode=1)),
        "near": entities(bounds=sphere),
        "west": entities(bounds=box),
        "unknown": entities(bounds=Bounds(type=77)),
        "states": [[*states.entities], [states.states[0].pose.position.x, len(states.states)]],
        "missing": [
            call(name, entity="eve").result.result
            for name in ("GetEntityState", "GetEntityInfo", "GetEntityBounds")
        ],
        "info": [info.info.category.category, *info.info.tags],
        "bounds": [[point.x, point.y, point.z] for point in bounds.bounds.points],
        "poses": [[one.name, one.pose.position.x, one.pose.position.y] for one in poses.poses],
        "world": call("GetCurrentWorld").world.name,
        "reset": features.SIMULATION_RESET in features.features,
    }


def reset(service):
    """Send a vehicle, reset, and send it again: goals, the clock and the pose around the reset."""
    from hunav_msgs.srv import ResetAgents
    from nav2_msgs.action import NavigateToPose
    from rosgraph_msgs.msg import Clock
    from simulation_interfaces.srv import ResetSimulation

    client = Client()
    client.listen("/clock", Clock)
    client.listen("/odom", Odometry)
    action = ActionClient(client.node, NavigateToPose, "/bot/navigate_to_pose")
    client.until(action.server_is_ready)

    def send(x, y):
        return client.wait(action.send_goal_async(NavigateToPose.Goal(pose=_pose(x, y))))

    def state():
        client.last.clear()
        client.until(lambda: {"/clock", "/odom"} <= client.last.keys())
        stamp, at = client.last["/clock"].clock, client.last["/odom"].pose.pose.position
        return [stamp.sec + stamp.nanosec / 1e9, math.hypot(at.x, at.y)]

    first = send(4.0, 10.0)
    client.until(lambda: state()[1] > 1.0)
    partly = None
    before = state()
    if service == "reset_simulation":
        partly = client.call(ResetSimulation, "/reset_simulation", scope=1).result.result
        done = client.call(ResetSimulation, "/reset_simulation").result.result == 1
    else:
        done = client.call(ResetAgents, "/reset_agents").ok
    after = state()
    result = client.wait(first.get_result_async())
    again = client.wait(send(3.0, 8.0).get_result_async())
    return {
        **{"partly": partly, "done": done, "before": before, "after": after},
        **{"first": result.status, "error": result.result.error_msg, "again": again.status},
    }


def change_states():
    """Pause, stop, step, play and quit: the results and states."""
    from simulation_interfaces.action import SimulateSteps
    from simulation_interfaces.msg import SimulationState
    from simulation_interfaces.srv import GetSimulationState, SetSimulationState, StepSimulation

    client, seen = Client(), []

    def change(state):
        request = SimulationState(state=state)
        answer = client.call(SetSimulationState, "/set_simulation_state", state=request)
        if state != SimulationState.STATE_QUITTING:
            present = client.call(GetSimulationState, "/get_simulation_state").state.state
            seen.append([answer.result.result, present])

    for state in (2, 2, 0, 1, 9, 2):
        change(state)
    steps = client.call(StepSimulation, "/step_simulation", steps=3).result.result
    action = ActionClient(client.node, SimulateSteps, "/simulate_steps")
    client.until(action.server_is_ready)
    made = []
    goal = SimulateSteps.Goal(steps=2**40)
    handle = client.wait(
        action.send_goal_async(goal, feedback_callback=lambda m: made.append(m.feedback))
    )
    client.until(lambda: len(made) > 3)
    client.wait(handle.cancel_goal_async())
    cancelled = client.wait(handle.get_result_async()).status
    change(3)
    return {"seen": seen, "steps": steps, "cancelled": cancelled}


def compete():
    """Drive a person and an AGV by the topics of the competition, and see what they publish."""
    from ariac_msgs.msg import AGVStatus, CompetitionState, HumanState, Order, Robots
    from ariac_msgs.srv import MoveAGV
    from geometry_msgs.msg import Point
    from std_msgs.msg import Bool
    from std_srvs.srv import Trigger

    client = Client()
    reached, orders = [], []
    client.node.create_subscription(
        Bool, "/ariac_human/position_reached", lambda m: reached.append(m.data), 10
    )
    orders_qos = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    client.node.create_subscription(Order, "/ariac/orders", orders.append, orders_qos)
    start = client.node.create_publisher(Bool, "/ariac/start_human", 10)
    goal = client.node.create_publisher(Point, "/ariac_human/goal_position", 10)
    phase = client.heard("/ariac/competition_state", CompetitionState, LATCHED)
    health = client.heard("/ariac/robot_health", Robots)
    client.listen("/ariac_human/state", HumanState)
    client.listen("/ariac/agv1_status", AGVStatus)
    client.until(lambda: client.node.count_subscribers("/ariac_human/goal_position"))
    start.publish(Bool(data=True))
    goal.publish(Point(x=math.nan))

    def arrived():
        if not reached:
            goal.publish(Point(x=-6.0, y=3.0))
        return reached

    client.until(arrived)
    at = client.last["/ariac_human/state"].human_position
    moved = [client.call(MoveAGV, "/ariac/move_agv1", location=k) for k in (77, 3)]
    client.until(lambda: client.last["/ariac/agv1_status"].location == 3)
    penalty = client.call(Trigger, "/ariac/set_human_safe_zone_penalty")
    ended = client.call(Trigger, "/ariac/end_competition")
    return {
        "phase": phase.competition_state,
        "health": [health.floor_robot, health.ceiling_robot],
        "at": [at.x, at.y],
        "moved": [answer.success for answer in moved],
        "done": penalty.success and ended.success,
        "orders": [
            [order.id, [part.part.type for part in order.kitting_task.parts]] for order in orders
        ],
    }


def advance_back():
    """Ask for people with stamps of a clock that goes backwards, until a line is due."""
    from hunav_msgs.srv import ComputeAgents

    client = Client()
    compute = client.node.create_client(ComputeAgents, "/compute_agents")
    client.until(compute.service_is_ready)
    times = []
    for second in (100, 101, 50, 51, 20, 21):
        request = ComputeAgents.Request()
        request.current_agents.header.stamp.sec = second
        answer = client.wait(compute.call_async(request))
        times.append(_places(answer.updated_agents)["ann"])
    return times


def second_clock():
    """Publish a clock, as another simulator does, until the vehicle has published for a second."""
    from rosgraph_msgs.msg import Clock

    client = Client()
    publisher = client.node.create_publisher(Clock, "/clock", 10)
    client.listen("/odom", Odometry)
    client.until(lambda: "/odom" in client.last)
    end = time.monotonic() + 1.0
    client.until(lambda: publisher.publish(Clock()) or time.monotonic() > end)


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
