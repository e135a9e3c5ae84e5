"""Independent simulation on roslibpy, with a person who reaches every goal at once.

The simulation starts the person, reports four arrivals and ends. It prints the goals.
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
# Another thread sends published messages. The server rejects the call after receiving them.
taken = threading.Event()
roslibpy.Service(ros, "/nowhere", "std_srvs/Trigger").call(
    roslibpy.ServiceRequest(), lambda _: taken.set(), lambda _: taken.set()
)
taken.wait()
ros.terminate()
