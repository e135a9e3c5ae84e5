"""Random one-minute trials of people and moving vehicles without fields, in an empty hall.

`python -m tests.random_trials.open_halls FIRST COUNT` prints each contact, each long wait for a
vehicle far away, and each person who turns to and fro. Contacts are faults if they are avoidable.
"""

import random
import sys

import numpy as np
import yaml

import sim

from .escape import avoidable, contacts, gaps

LONGEST_WAIT = 5.0
"""Longest wait for a vehicle that is farther than `FAR` away, s."""

FAR = 5.0
"""Distance of such a vehicle, m."""

MOST_TURNS = 2
"""Number of turns of more than 90° within `AROUND` metres and `WHILE` seconds."""

AROUND, WHILE = 2.0, 10.0


def open_hall(number):
    """Return the trial of this number: one to eight people, one or two vehicles."""
    rng = random.Random(number)
    length, width = rng.choice([(16, 10), (16, 10), (16, 10), (9, 6)])

    def place(margin=2.0):
        return [
            round(rng.uniform(margin, length - margin), 1),
            round(rng.uniform(margin, width - margin), 1),
        ]

    def vehicle(at):
        missions = [{"go": place(1.5)}, {"go": place(1.5)}]
        speed = round(rng.uniform(0.6, 1.5), 1)
        return {"kind": "amr", "at": at, "max_speed": speed, "missions": missions, "repeat": True}

    machines = {"v": vehicle([1.5, width / 2, 0.0])}
    if length > 10 and rng.random() < 0.25:
        machines["w"] = vehicle([length - 1.5, width / 2, 3.14])
    floor = {
        "boundary": [[0, 0], [length, 0], [length, width], [0, width]],
        "stations": {name: place() for name in "abc"},
        "safe_zone": {"at": [length - 1, width - 1]},
    }
    count = rng.choice([1, 1, 2, 3, 4, 8]) if length > 10 else rng.choice([1, 2, 3])
    people = [{"name": "p1", "at": "anywhere"}]
    if count > 1:
        people = [{"name": "p", "count": count, "at": "anywhere"}]
    keys = {"duration": 60, "seed": number, "rules": "observe"}
    keys |= {"floorplan": floor, "people": people, "machines": machines}
    return sim.Trial.parse(yaml.safe_dump(keys))


def under_way(run, name):
    """Return the intervals in which a person walks to one goal (s)."""
    since, intervals = None, []
    for event in run.events:
        if event.get("person") == name and event["kind"] in ("goal", "arrived"):
            if since is not None:
                intervals.append((since, event["t"]))
            since = event["t"] if event["kind"] == "goal" else None
    return intervals if since is None else [*intervals, (since, run.duration)]


def long_waits(run):
    """Return person, end (s) and duration (s) of waits while all vehicles are far away."""
    times = np.arange(0.0, run.duration, 0.05)
    far = np.ones(len(times), dtype=bool)
    for name in (person.name for person in run.trial.people):
        walk = run.motions[name]
        places = walk.position(times)
        far = np.all(
            [
                gaps(places, run.motions[machine.name], machine.bounds, times) > FAR
                for machine in run.scene.machines
            ],
            axis=0,
        )
        stands = np.hypot(*walk.velocity(times)[:, :2].T) < 1e-6
        for begin, end in under_way(run, name):
            waits = stands & far & (times >= begin) & (times <= end)
            edges = np.flatnonzero(np.diff(np.concatenate([[0], waits, [0]])))
            for first, last in edges.reshape(-1, 2):
                if (last - first) * 0.05 > LONGEST_WAIT:
                    yield name, times[last - 1], (last - first) * 0.05


def dithering(run):
    """Return person, time (s) and number of turns to and fro on the way to one goal."""
    times = np.arange(0.0, run.duration, 0.05)
    for name in (person.name for person in run.trial.people):
        walk = run.motions[name]
        places, velocity = walk.position(times), walk.velocity(times)[:, :2]
        for begin, end in under_way(run, name):
            way = np.flatnonzero((times >= begin) & (times <= end) & (np.hypot(*velocity.T) > 0.05))
            back = (velocity[way[1:]] * velocity[way[:-1]]).sum(axis=1) < 0.0
            turns = way[1:][back]
            for k in turns:
                near = np.hypot(*(places[turns] - places[k]).T) <= AROUND
                soon = (times[turns] >= times[k]) & (times[turns] <= times[k] + WHILE)
                if (count := int((near & soon).sum())) > MOST_TURNS:
                    yield name, times[k], count
                    break


def faults_in_hall(number):
    """Return the faults of the trial with this number and other notes, in words."""
    try:
        trial = open_hall(number)
        run = sim.run(trial)
    except sim.TrialError:  # a station or a start without room
        return [], []
    noted, wrong = [], []
    for contact in contacts(run):
        name, vehicle, t, _ = contact
        way_out = avoidable(trial, contact)
        noted.append(f"{number}: {vehicle} runs into {name} at t = {t:.2f} s")
        if way_out is not None:
            wrong.append(f"{noted[-1]}, who could have left at {way_out}")
    for name, t, duration in long_waits(run):
        noted.append(f"{number}: {name} waits {duration:.1f} s until t = {t:.2f} s")
    for name, t, count in dithering(run):
        noted.append(f"{number}: {name} turns {count} times from t = {t:.2f} s on")
    return wrong, noted


def main():
    """Run the trials, and print the notes and faults of each."""
    first, count = map(int, sys.argv[1:])
    broken = 0
    for number in range(first, first + count):
        wrong, noted = faults_in_hall(number)
        broken += bool(wrong)
        for one in (*noted, *(f"fault: {fault}" for fault in wrong)):
            print(one, flush=True)
    print(f"{count} trials, {broken} with faults")


if __name__ == "__main__":
    main()
