"""Somebody else's simulation on roslibpy: a person who is at every goal at once.

It starts the person, lets them arrive four times, and ends; then it tells where they were sent.
usage: python simulation_roslibpy.py HOST PORT
"""

import json
import sys
import threading

import roslibpy

ARRIVALS = 4
goals = []
sent = threading.Event()
ros = roslibpy.Ros(host=sys.argv[1], port=int(sys.argv[2]))


def topic(name, type_):
    return roslibpy.Topic(ros, name, type_)


def send(point):
    goals.append([point["x"], point["y"]])
    sent.set()
    if len(goals) <= ARRIVALS:
        reached.publish({"data": True})


ros.run()
start = topic("/ariac/start_human", "std_msgs/Bool")
reached = topic("/ariac_human/position_reached", "std_msgs/Bool")
phase = topic("/ariac/competition_state", "ariac_msgs/CompetitionState")
for one in (start, reached, phase):
    one.advertise()
topic("/ariac_human/goal_position", "geometry_msgs/Point").subscribe(send)
while not sent.wait(0.2):
    start.publish({"data": True})
while len(goals) <= ARRIVALS:
    sent.clear()
    sent.wait(1.0)
phase.publish({"competition_state": 4})
print(json.dumps(goals), flush=True)
# What was published is sent by another thread; the server refuses a call once it has taken it.
taken = threading.Event()
roslibpy.Service(ros, "/nowhere", "std_srvs/Trigger").call(
    roslibpy.ServiceRequest(), lambda _: taken.set(), lambda _: taken.set()
)
taken.wait()
ros.terminate()
