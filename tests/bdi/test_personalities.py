"""What the built-in people do when the gantry comes near."""

import pytest

import bdi

STATIONS = ["station(s1,0,0)", "station(s2,10,0)", "station(s3,10,10)", "station(s4,0,10)"]
PLACES = {"s1": "move(0,0,0)", "s2": "move(10,0,0)", "s3": "move(10,10,0)", "s4": "move(0,10,0)"}


class Scene:
    """A person and what has happened to it; `did` has its actions since the last look."""

    def __init__(self, personality, *beliefs):
        self._actions = []
        self.agent = bdi.Agent(
            bdi.load(personality), beliefs=[*STATIONS, *beliefs], act=self._act, print=None
        )
        self.agent.advance(0.0)

    def _act(self, action):
        self._actions.append((self.agent.now, str(action)))
        return True

    def at(self, time, percept=None):
        if percept is not None:
            self.agent.add_percept(percept)
        self.agent.advance(time)
        return self.did()

    def did(self):
        actions, self._actions = self._actions, []
        return actions

    def walking(self):
        """Started, and on the way from the first station to the second."""
        self.at(0.0, "human_start")
        self.at(5.0, "work_completed(0)")
        return self


EVERYBODY = sorted(bdi.programs())


def test_the_names():
    names = "antagonistic curious helpful indifferent scared surprised threatening"
    assert " ".join(EVERYBODY) == names


@pytest.mark.parametrize("name", EVERYBODY)
def test_patrols_in_a_ring_once_started(name):
    scene = Scene(name)
    assert scene.at(1.0, "gantry_detected(0)") == []
    assert scene.at(2.0, "human_start") == [(2.0, PLACES["s1"])]
    order = [scene.at(3.0 + i, f"work_completed({i})")[0][1] for i in range(5)]
    assert order == [PLACES[s] for s in ("s2", "s3", "s4", "s1", "s2")]


@pytest.mark.parametrize("name", EVERYBODY)
def test_any_number_of_stations(name):
    for stations in (["station(only,1,2)"], ["station(a,1,2)", "station('B b',3,4)"]):
        actions = []
        agent = bdi.Agent(
            bdi.load(name), beliefs=stations, act=lambda a, log=actions: log.append(str(a)) or True
        )
        agent.advance(0.0)
        agent.add_percept("human_start")
        for i in range(3):
            agent.advance(float(i))
            agent.add_percept(f"work_completed({i})")
        agent.advance(9.0)
        ring = ["move(1,2,0)", "move(3,4,0)"][: len(stations)]
        assert actions == [ring[i % len(ring)] for i in range(4)]


@pytest.mark.parametrize("name", EVERYBODY)
@pytest.mark.parametrize(
    ("percept", "action", "belief", "pause"),
    [
        ("gantry_disabled(0)", "teleport_safe", None, 8.0),
        ("gantry_disabled(0)", "teleport_safe", "pause_after_violation(10000)", 10.0),
        ("agv_danger(0)", "teleport_agv", None, 8.0),
        ("agv_danger(0)", "teleport_agv", "pause_after_agv(2500)", 2.5),
    ],
)
def test_begins_anew_after_coming_too_close(name, percept, action, belief, pause):
    scene = Scene(name, *([] if belief is None else [belief])).walking()
    scene.did()
    first = [what for _, what in scene.at(7.0, percept)]
    assert [what for what in first if what != "walk_speed(1)"] == [action]
    assert scene.at(7.0 + pause - 0.001) == []
    assert scene.at(7.0 + pause) == [(7.0 + pause, PLACES["s1"])]
    assert scene.at(30.0, "work_completed(1)") == [(30.0, PLACES["s2"])]


@pytest.mark.parametrize("name", EVERYBODY)
def test_tries_again_where_the_way_is_blocked_and_then_goes_elsewhere(name):
    scene = Scene(name).walking()
    scene.did()
    for i in range(3):
        assert scene.at(10.0 + 5 * i, f"path_blocked({i})") == []
        assert scene.at(13.0 + 5 * i) == [(12.0 + 5 * i, PLACES["s2"])]
    scene.at(25.0, "goal_blocked(0)")
    assert scene.at(28.0) == [(27.0, PLACES["s3"])]


def test_indifferent_takes_no_notice():
    scene = Scene("indifferent").walking()
    scene.did()
    assert scene.at(6.0, "gantry_detected(0)") == []


def test_antagonistic_walks_up_to_the_gantry_and_then_on():
    scene = Scene("antagonistic").walking()
    scene.did()
    assert scene.at(6.0, "gantry_detected(0)") == [(6.0, "stop_movement"), (6.0, "move_to_gantry")]
    assert scene.at(9.0, "work_completed(1)") == [(9.0, PLACES["s3"])]
    assert scene.at(15.0, "work_completed(2)") == [(15.0, PLACES["s4"])]


def test_helpful_turns_round_but_not_on_the_spot():
    scene = Scene("helpful").walking()
    scene.did()
    assert scene.at(6.0, "gantry_detected(0)") == [(6.0, "stop_movement")]
    # One comes while it thinks, another within five seconds of the turn: neither counts.
    assert scene.at(6.5, "gantry_detected(1)") == []
    assert scene.at(11.9) == [(7.0, PLACES["s1"])]
    assert scene.at(11.9, "gantry_detected(2)") == []
    assert scene.at(11.95, "work_completed(1)") == [(11.95, PLACES["s4"])]
    assert scene.at(12.0, "gantry_detected(3)") == [(12.0, "stop_movement")]
    assert scene.at(14.0) == [(13.0, PLACES["s1"])]


def test_helpful_turns_again_after_five_seconds():
    scene = Scene("helpful").walking()
    scene.at(6.0, "gantry_detected(0)")
    scene.at(8.0)
    scene.did()
    assert scene.at(12.0, "gantry_detected(1)") == [(12.0, "stop_movement")]
    assert scene.at(14.0) == [(13.0, PLACES["s2"])]


def test_helpful_figures_can_be_told():
    scene = Scene("helpful", "consideration(200)", "steadfast(500)").walking()
    scene.did()
    scene.at(6.0, "gantry_detected(0)")
    assert scene.at(6.6)[-1] == (6.2, PLACES["s1"])
    assert scene.at(6.7, "gantry_detected(1)") == [(6.7, "stop_movement")]
    assert scene.at(7.0) == [(6.9, PLACES["s2"])]


def test_surprised_watches_and_walks_on():
    scene = Scene("surprised").walking()
    scene.did()
    assert scene.at(6.0, "gantry_detected(0)") == [(6.0, "stop_movement"), (6.0, "face_gantry")]
    assert scene.at(7.0, "gantry_detected(1)") == []
    assert scene.at(20.0) == [(9.0, PLACES["s2"])]


def test_scared_keeps_away():
    scene = Scene("scared", "retreat(4)").walking()
    scene.did()
    assert scene.at(6.0, "gantry_detected(0)") == [(6.0, "stop_movement"), (6.0, "move_away(4)")]
    assert scene.at(8.0, "work_completed(1)") == []
    assert scene.at(20.0) == [(11.0, PLACES["s3"])]


def test_curious_comes_slowly_looks_and_loses_interest():
    scene = Scene("curious").walking()
    scene.did()
    came = ["stop_movement", "walk_speed(0.4)", "move_to_gantry"]
    assert [what for _, what in scene.at(6.0, "gantry_detected(0)")] == came
    assert scene.at(9.0, "work_completed(1)") == [(9.0, "face_gantry")]
    left = [(14.0, "stop_movement"), (14.0, "walk_speed(1)"), (14.0, PLACES["s2"])]
    assert scene.at(15.0) == left
    assert scene.at(20.0, "gantry_detected(1)") == []
    assert [what for _, what in scene.at(34.0, "gantry_detected(2)")] == came


def test_threatening_steps_into_the_way():
    scene = Scene("threatening").walking()
    scene.did()
    assert scene.at(6.0, "gantry_detected(0)") == [(6.0, "stop_movement"), (6.0, "step_between")]
    assert scene.at(8.0, "work_completed(1)") == [(8.0, "face_gantry")]
    assert scene.at(20.0) == [(12.0, PLACES["s2"])]


@pytest.mark.parametrize("name", EVERYBODY)
def test_the_programs_say_who_they_are(name):
    text = bdi.programs()[name].read_text(encoding="utf-8")
    assert text.startswith(f"// {name.capitalize()}: ")


@pytest.mark.parametrize("name", EVERYBODY)
def test_own_programs_may_include_the_patrol(name, tmp_path):
    path = tmp_path / "mine.asl"
    path.write_text(f'+gantry_detected(_) <- wave. {{ include("{name}.asl") }}', encoding="utf-8")
    agent = bdi.Agent(bdi.parse_file(path), beliefs=STATIONS)
    agent.advance(1.0)
