"""The competition's agent on the bridge, imitated by its protocol and its two time windows."""

import math
from contextlib import suppress
from dataclasses import replace

import pytest
from bridge_parts import Pacer, make_agent, served, trial
from websockets.exceptions import ConnectionClosedOK

import bdi
import sim
from sim.people.perception import Percepts

DROPS = 10.0
"""Time (s) of dropped violations after the start, the last violation or a teleport."""

LOOKS = 20.0
"""Time (s) without checks for the gantry after the start, a teleport or noticing the gantry."""

SPEED = 8.0
"""Speed of the trial. The time windows above are those at speed 1."""

LATE = 1 / 64
"""Maximum latency in real time (s), an eighth of a second at its speed."""

MAKES_READY = 0.5
"""Time (s) after its subscription without received messages."""

COMMANDS = {
    "move": ("/ariac_human/goal_position", "geometry_msgs/Point"),
    "move_to_gantry": ("/ariac_human/goal_position", "geometry_msgs/Point"),
    "stop_movement": ("/ariac_human/stop", "std_msgs/Bool"),
    "teleport_safe": ("/ariac_human/go_home", "std_msgs/Bool"),
    "teleport_agv": ("/ariac_human/go_home", "std_msgs/Bool"),
}
HEARD = {
    "/ariac/start_human": "std_msgs/Bool",
    "/ariac_human/position_reached": "std_msgs/Bool",
    "/ariac_human/unsafe_distance": "std_msgs/Bool",
    "/ariac_human/state": "ariac_msgs/HumanState",
    "/ariac/competition_state": "ariac_msgs/CompetitionState",
}


class Original:
    """Agent that drives a person in real time like the original, dropping the same messages."""

    def __init__(self, client, session, a_trial, speed):
        self._client = client
        self._session = session
        self._speed = speed
        self._agent = make_agent(
            a_trial.people[0],
            a_trial,
            act=self._act,
            print=lambda text: None,
            settings=bdi.AgentSettings(),
        )
        self._percepts = Percepts(self._agent)
        self._came = self._session.time
        self._unsafe_at = self._came
        self._looks_from = math.inf
        self._distance = math.inf
        self.dropped = 0

    def drive(self):
        for topic, type_ in set(COMMANDS.values()):
            self._client.send(op="advertise", topic=topic, type=type_)
        for topic, type_ in HEARD.items():
            self._client.subscribe(topic, type=type_)
        while True:
            said = self._client.hear()
            if said["op"] == "publish" and not self._hear(said["topic"], said["msg"]):
                return
            self._agent.advance((self._session.time - self._came) * self._speed)

    def _hear(self, topic, message):
        now = self._session.time
        if topic == "/ariac/competition_state":
            return message["competition_state"] != 4
        if topic == "/ariac/start_human" and now - self._came > MAKES_READY:
            self._percepts.see("human_start")
            self._unsafe_at = now
            self._looks_from = now + LOOKS / self._speed
        elif topic == "/ariac_human/state":
            self._look(now, message)
        elif topic == "/ariac_human/position_reached":
            self._percepts.count("work_completed")
        elif topic == "/ariac_human/unsafe_distance":
            if now - self._unsafe_at < DROPS / self._speed:
                self.dropped += 1
                return True
            self._unsafe_at = now
            self._percepts.count("gantry_disabled" if message["data"] else "agv_danger")
        return True

    def _look(self, now, state):
        here, self._gantry = (
            (state[f"{who}_position"]["x"], state[f"{who}_position"]["y"])
            for who in ("human", "robot")
        )
        walks, moves = (
            math.hypot(state[f"{who}_velocity"]["x"], state[f"{who}_velocity"]["y"])
            for who in ("human", "robot")
        )
        before, self._distance = self._distance, math.dist(here, self._gantry)
        is_near = self._distance < 1.75 * min(walks * (1.0 + 1.5) + moves * 1.0 + 1.2, 5.0)
        if is_near and self._distance < before and now >= self._looks_from:
            self._looks_from = now + LOOKS / self._speed
            self._percepts.see("gantry_at", *self._gantry)
            self._percepts.count("gantry_detected")

    def _act(self, action):
        topic, _ = COMMANDS[action.functor]
        if action.functor == "move_to_gantry":
            self._client.publish("/ariac_human/stop", data=True)
            self._client.publish(topic, x=self._gantry[0], y=self._gantry[1], z=0.0)
        elif action.functor == "move":
            x, y, z = action.args
            self._client.publish(topic, x=x, y=y, z=z)
        else:
            if action.functor.startswith("teleport"):
                self._unsafe_at = self._session.time
                self._looks_from = self._unsafe_at + LOOKS / self._speed
            self._client.publish(topic, data=action.functor != "teleport_agv")
        return True


def driven(a_trial, speed=SPEED):
    """Return the run driven by the original, the run of the trial alone, and the original."""
    (person,) = a_trial.people
    outside = replace(a_trial, people=(replace(person, personality="external"),))
    with served(outside, speed=speed, grace=1.0, by_hand=True) as session:
        with Pacer(session, LATE) as client:
            original = Original(client, session, a_trial, speed)
            with suppress(ConnectionClosedOK):  # the trial may end while the original sends
                original.drive()
        return session.join(), sim.run(a_trial), original


def times(run, kind):
    return [event["t"] for event in run.events if event["kind"] == kind]


def require_same_goals(across, within):
    """Require the goals of the agent within, to the end, as many as the latency permits."""
    goals, expected = (
        [event["at"] for event in run.events if event["kind"] == "goal"] for run in (across, within)
    )
    assert goals == expected[: len(goals)]
    assert times(across, "goal")[-1] > times(within, "goal")[-1] - 30.0


@pytest.mark.parametrize("duration", [40.0, pytest.param(275.0, marks=pytest.mark.slow)])
def test_the_original_agent_continues_to_the_end(duration):
    across, within, _ = driven(
        replace(trial("indifferent", duration), rules=sim.RULE_SETS["ariac2023"])
    )
    require_same_goals(across, within)
    violations = times(across, "violation")
    assert violations
    assert times(across, "teleport") == violations


@pytest.mark.slow
def test_an_antagonistic_original_meets_the_gantry_to_the_end():
    # In real time, a teleport may end at an earlier goal. The test therefore compares how often the
    # person meets the gantry.
    across, within, _ = driven(
        replace(trial("antagonistic", 275.0), rules=sim.RULE_SETS["ariac2023"])
    )
    violations, expected = times(across, "violation"), times(within, "violation")
    assert set(violations) <= set(times(across, "teleport"))
    assert len(violations) > 0.6 * len(expected)
    assert times(across, "goal")[-1] > times(within, "goal")[-1] - 30.0


@pytest.mark.slow
def test_a_helpful_original_makes_room_to_the_end():
    # The gantry returns at the same speed and meets the person where a tenth of a second decides
    # which station the person has just left. The goals are therefore counted, not compared one by
    # one.
    a_trial = replace(trial("helpful", 120.0), rules=sim.RULE_SETS["ariac2023"])
    across, within, _ = driven(a_trial, speed=5.0)
    assert not times(across, "violation")
    assert times(sim.run(replace(a_trial, people=trial("indifferent").people)), "violation")
    assert len(times(across, "goal")) > 0.6 * len(times(within, "goal"))
    assert times(across, "goal")[-1] > a_trial.duration - 30.0


def test_a_message_that_the_original_drops_is_received_later():
    at_once = sim.GantryEntry(at=(-10.8, -1.0, 0.0))
    a_trial = replace(trial("indifferent", 30.0), rules=sim.RULE_SETS["ariac2023"], gantry=at_once)
    across, within, original = driven(a_trial)
    assert original.dropped > 0
    require_same_goals(across, within)
    assert (
        times(across, "goal")[1]
        > times(across, "violation")[0] + sim.RULE_SETS["ariac2023"].pause_after_violation
    )


def test_a_violation_is_repeated_until_it_is_answered():
    a_trial = trial(duration=60.0)
    with (
        served(a_trial, speed=SPEED, by_hand=True) as session,
        Pacer(session) as client,
    ):
        client.subscribe("/ariac/start_human", type="std_msgs/Bool")
        client.subscribe("/ariac_human/unsafe_distance", type="std_msgs/Bool")
        assert client.message("/ariac/start_human") == {"data": True}
        client.publish("/ariac_human/goal_position", x=-2.9, y=0.6)
        for _ in range(5):
            assert client.message("/ariac_human/unsafe_distance") == {"data": True}
        client.publish("/ariac_human/go_home", data=True)
        client.heard()
        session.move(0.3)
        assert client.heard() == []
        client.call("/ariac/end_competition")
        run = session.join()
    assert [event["kind"] for event in run.events].count("teleport") == 1


def test_an_agent_may_prepare_before_the_trial_begins():
    patient = served(trial(duration=5.0), speed=SPEED, grace=30.0, by_hand=True)
    with patient as session, Pacer(session) as client:
        client.subscribe("/ariac/start_human", type="std_msgs/Bool")
        client.settle()
        session.move(29.0)
        assert client.heard() == []
        assert session.now == 0.0
        client.send(op="call_service", service="/ariac/start_competition")
        assert client.message("/ariac/start_human") == {"data": True}
        session.join()


def test_a_trial_begins_after_the_grace_period_of_an_agent():
    patient = served(trial(duration=5.0), speed=SPEED, grace=30.0, by_hand=True)
    with patient as session, Pacer(session) as client:
        client.subscribe("/ariac/start_human", type="std_msgs/Bool")
        client.settle()
        begun = session.time
        assert client.message("/ariac/start_human") == {"data": True}
        assert 30.0 <= session.time - begun < 30.2
