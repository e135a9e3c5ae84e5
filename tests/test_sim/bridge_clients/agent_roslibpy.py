"""Agent on roslibpy that walks from station to station, and prints the messages it received.

usage: python agent_roslibpy.py HOST PORT
"""

import json
import sys
import threading

import roslibpy

STATIONS = [(-10.8, -3.75), (-10.8, 3.75), (-5.0, 3.75), (-5.0, -3.75)]
heard = {"states": 0, "clocks": 0, "reached": 0, "unsafe": 0, "topics": 0, "services": 0}
over = threading.Event()
ros = roslibpy.Ros(host=sys.argv[1], port=int(sys.argv[2]))
goal = roslibpy.Topic(ros, "/ariac_human/goal_position", "geometry_msgs/Point")
home = roslibpy.Topic(ros, "/ariac_human/go_home", "std_msgs/Bool")
walked = 0


def count(what):
    def hear(_):
        heard[what] += 1

    return hear


def walk_on(*_):
    global walked
    x, y = STATIONS[walked % len(STATIONS)]
    walked += 1
    goal.publish({"x": x, "y": y, "z": 0.0})


def arrive(_):
    heard["reached"] += 1
    walk_on()


def flee(message):
    global walked
    heard["unsafe"] += 1
    home.publish({"data": message["data"]})
    walked = 0
    walk_on()


def end(message):
    if message["competition_state"] == 4:
        over.set()


def subscribe(name, type_, callback):
    roslibpy.Topic(ros, name, type_).subscribe(callback)


ros.run()
heard["topics"] = len(ros.get_topics())
move = roslibpy.Service(ros, "/ariac/move_agv4", "ariac_msgs/MoveAGV")
heard["services"] += move.call(roslibpy.ServiceRequest({"location": 1}))["success"]
subscribe("/ariac_human/state", "ariac_msgs/HumanState", count("states"))
subscribe("/clock", "rosgraph_msgs/Clock", count("clocks"))
subscribe("/ariac_human/position_reached", "std_msgs/Bool", arrive)
subscribe("/ariac_human/unsafe_distance", "std_msgs/Bool", flee)
subscribe("/ariac/competition_state", "ariac_msgs/CompetitionState", end)
subscribe("/ariac/start_human", "std_msgs/Bool", walk_on)
finished = over.wait(280)
print(json.dumps(heard), flush=True)
ros.terminate()
sys.exit(0 if finished else 1)
