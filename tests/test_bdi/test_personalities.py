"""Reactions of the built-in personalities to the gantry."""

import pytest

import bdi

STATIONS = ["station(s1,0,0)", "station(s2,10,0)", "station(s3,10,10)", "station(s4,0,10)"]
PLACES = {"s1": "move(0,0,0)", "s2": "move(10,0,0)", "s3": "move(10,10,0)", "s4": "move(0,10,0)"}


class Scene:
    """A person alone. `at` returns the actions since the last call, with their times."""

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
        actions, self._actions = self._actions, []
        return actions

    def walking(self):
        """Return a scene in which the person walks from the first station to the second."""
        self.at(0.0, "human_start")
        self.at(5.0, "work_completed(0)")
        return self


EVERYBODY = sorted(bdi.programs())


@pytest.mark.parametrize("name", EVERYBODY)
def test_people_patrol_in_a_ring_after_the_start(name):
    scene = Scene(name)
    assert scene.at(1.0, "gantry_detected(0)") == []
    assert scene.at(2.0, "human_start") == [(2.0, PLACES["s1"])]
    order = [scene.at(3.0 + i, f"work_completed({i})")[0][1] for i in range(5)]
    assert order == [PLACES[s] for s in ("s2", "s3", "s4", "s1", "s2")]


@pytest.mark.parametrize("name", EVERYBODY)
def test_people_patrol_any_number_of_stations(name):
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
def test_people_restart_the_patrol_after_a_violation(name, percept, action, belief, pause):
    scene = Scene(name, *([] if belief is None else [belief])).walking()
    first = [what for _, what in scene.at(7.0, percept)]
    assert [what for what in first if what != "walk_speed(1)"] == [action]
    assert scene.at(7.0 + pause - 0.001) == []
    assert scene.at(7.0 + pause) == [(7.0 + pause, PLACES["s1"])]
    assert scene.at(30.0, "work_completed(1)") == [(30.0, PLACES["s2"])]


@pytest.mark.parametrize("name", EVERYBODY)
def test_people_retry_a_blocked_path_and_then_choose_the_next_station(name):
    scene = Scene(name).walking()
    for i in range(3):
        assert scene.at(10.0 + 5 * i, f"path_blocked({i})") == []
        assert scene.at(13.0 + 5 * i) == [(12.0 + 5 * i, PLACES["s2"])]
    scene.at(25.0, "goal_blocked(0)")
    assert scene.at(28.0) == [(27.0, PLACES["s3"])]


# Personality and beliefs, then steps: time (s), percept, and the times and names of the actions
# since the last step.
REACTIONS = [
    ("indifferent", "6 gantry_detected(0) >"),
    (
        "antagonistic",
        "6 gantry_detected(0) > 6 stop_movement move_to_gantry",
        *("9 work_completed(1) > 9 s3", "15 work_completed(2) > 15 s4"),
    ),
    (
        "antagonistic reaction(antagonistic,2500) reaction(helpful,1500)",
        *("6 gantry_detected(0) > 6 stop_movement", "8 > ", "8.5 > 8.5 move_to_gantry"),
        *("9 gantry_detected(1) > 9 stop_movement", "10 gantry_disabled(0) > 10 teleport_safe"),
        "20 > 18 s1",
    ),
    (
        "helpful reaction(antagonistic,2500) reaction(helpful,1500)",
        *("6 gantry_detected(0) > 6 stop_movement", "7.4 >", "8 > 7.5 s1"),
    ),
    (
        "helpful",  # percepts while it thinks, or within five seconds of a turn, do not count
        *("6 gantry_detected(0) > 6 stop_movement", "6.5 gantry_detected(1) >", "11.9 > 7 s1"),
        *("11.9 gantry_detected(2) >", "11.95 work_completed(1) > 11.95 s4"),
        *("12 gantry_detected(3) > 12 stop_movement", "14 > 13 s1"),
    ),
    (
        "helpful",
        *("6 gantry_detected(0) > 6 stop_movement", "8 > 7 s1"),
        *("12 gantry_detected(1) > 12 stop_movement", "14 > 13 s2"),
    ),
    (
        "helpful consideration(200) steadfast(500)",
        *("6 gantry_detected(0) > 6 stop_movement", "6.6 > 6.2 s1"),
        *("6.7 gantry_detected(1) > 6.7 stop_movement", "7 > 6.9 s2"),
    ),
    (
        "surprised",
        "6 gantry_detected(0) > 6 stop_movement face_gantry",
        *("7 gantry_detected(1) >", "20 > 9 s2"),
    ),
    (
        "scared retreat(4)",
        "6 gantry_detected(0) > 6 stop_movement move_away(4)",
        *("8 work_completed(1) >", "20 > 11 s3"),
    ),
    (
        "curious",
        "6 gantry_detected(0) > 6 stop_movement walk_speed(0.4) move_to_gantry",
        *("9 work_completed(1) > 9 face_gantry", "15 > 14 stop_movement walk_speed(1) s2"),
        "20 gantry_detected(1) >",
        "34 gantry_detected(2) > 34 stop_movement walk_speed(0.4) move_to_gantry",
    ),
    (
        "threatening",
        "6 gantry_detected(0) > 6 stop_movement step_between",
        *("8 work_completed(1) > 8 face_gantry", "20 > 12 s2"),
    ),
]


@pytest.mark.parametrize(("person", "script"), [(r[0], r[1:]) for r in REACTIONS])
def test_people_react_to_the_gantry_by_personality(person, script):
    scene = Scene(*person.split()).walking()
    for line in script:
        step, _, expected = line.partition(">")
        time, *percept = step.split()
        at, *actions = expected.split() or ["0"]
        wanted = [(float(at), PLACES.get(action, action)) for action in actions]
        assert scene.at(float(time), *percept) == wanted, line


@pytest.mark.parametrize("name", EVERYBODY)
def test_programs_are_described_at_their_beginning(name):
    text = bdi.programs()[name].read_text(encoding="utf-8")
    assert text.startswith(f"// {name.capitalize()}: ")


@pytest.mark.parametrize("name", EVERYBODY)
def test_custom_programs_may_include_the_patrol(name, tmp_path):
    path = tmp_path / "mine.asl"
    path.write_text(f'+gantry_detected(_) <- wave. {{ include("{name}.asl") }}', encoding="utf-8")
    done = []
    agent = bdi.Agent(
        bdi.parse_file(path), beliefs=STATIONS, act=lambda action: done.append(str(action)) or True
    )
    agent.add_percept("human_start")
    agent.advance(1.0)
    assert done[0].startswith("move(")
    agent.add_percept("gantry_detected(1)")
    agent.advance(100.0)
    assert "wave" in done  # the program's own plan precedes that of the patrol
