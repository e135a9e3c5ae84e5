"""People who stand or walk on the course of a vehicle leave it in time."""

import pytest
import yaml

import sim
from sim.people.crowd.ground import corners_passed

HALL = {
    "boundary": [[0, 0], [16, 0], [16, 10], [0, 10]],
    "stations": {"a": [8.9, 4.9], "b": [15, 9]},
    "safe_zone": {"at": [15, 9]},
}


def run_in_hall(people, machines, duration=25, **keys):
    keys |= {"floorplan": HALL, "duration": duration, "rules": "observe"}
    return sim.run(sim.Trial.parse(yaml.safe_dump(keys | {"people": people, "machines": machines})))


def vehicle(at, *goals, **keys):
    return {
        "kind": "amr",
        "at": at,
        "max_speed": 0.8,
        "missions": [{"go": [*at]} for at in goals],
    } | keys


def test_a_person_alone_is_not_run_over_on_open_floor():
    machines = {"v": vehicle([2, 4.4, 3.1], (14, 6.3))}
    run = run_in_hall([{"name": "bob", "at": [8.5, 6.1]}], machines)
    assert run.summary["contacts"] == 0
    assert run.summary["people"]["bob"]["visits"]


RESTS = {"personality": "indifferent", "start": {"time": 1e3}}


@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("speed", [0.5, 1.5])
def test_people_without_a_goal_step_off_the_course(count, speed):
    people = [{"name": f"p{k}", "at": [7.0 + 0.7 * k, 5.0], **RESTS} for k in range(count)]
    run = run_in_hall(people, {"v": vehicle([2, 5, 0], (14, 5), max_speed=speed)})
    assert run.summary["contacts"] == 0
    assert run.motions["p0"].position(run.duration)[1] != 5.0


def test_a_person_steps_aside_each_time_the_vehicle_comes():
    goals = [(14, 5), (2, 5), (14, 7), (2, 7), (14, 5)]
    bot = vehicle([2, 5, 0], *goals, max_speed=1.5)
    run = run_in_hall([{"name": "p", "at": [7.0, 5.0], **RESTS}], {"v": bot}, 80)
    assert run.summary["contacts"] == 0


def test_a_person_who_never_steps_aside_for_people_does_so_for_a_vehicle():
    person = {"name": "p", "at": [7.0, 5.0], "manners": {"steps_aside": False}, **RESTS}
    run = run_in_hall([person], {"v": vehicle([2, 5, 0], (14, 5))})
    assert run.summary["contacts"] == 0


def test_a_person_takes_a_goal_that_a_vehicle_passes_much_later(tmp_path):
    (tmp_path / "go.asl").write_text("+human_start <- move(12.0, 5.0, 0).\n")
    keys = {"floorplan": HALL, "duration": 40, "rules": "observe"}
    keys["people"] = [{"name": "p", "at": [12.0, 6.5], "personality": "go.asl"}]
    keys["machines"] = {"v": vehicle([2, 5, 0], (14, 5), max_speed=0.5)}
    run = sim.run(sim.Trial.parse(yaml.safe_dump(keys), folder=tmp_path))
    (arrived,) = [event["t"] for event in run.events if event["kind"] == "arrived"]
    assert arrived < 3.0
    assert run.summary["contacts"] == 0


def test_corners_before_the_nearest_point_of_a_route_are_passed():
    course = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)]
    assert corners_passed(course, (2.0, 0.1)) == 0
    assert corners_passed(course, (4.1, 2.0)) == 1
    assert corners_passed(course, (2.0, 4.1)) == 2
    assert corners_passed(course[:2], (9.0, 9.0)) == 0
