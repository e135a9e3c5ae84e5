"""Goals that no person or machine of a trial can reach, as reported by `check` and by a run."""

import pytest

import sim

FLOOR = """\
floorplan:
  boundary: [[0, 0], [24, 0], [24, 14], [0, 14]]
  stations: {{a: [3, 7], b: [21, 7]}}
  safe_zone: {{at: [3, 3]}}
  {floor}
duration: 20
rules: observe
{rest}
"""
WALL = "obstacles: {wall: {x: [12, 12.2], y: [0, 14], z: [0, 3]}}"
CART = "machines: {cart: {kind: amr, at: [3, 7, 0], missions: [{go: b}]}}"


def notices(floor, rest):
    trial = sim.Trial.parse(FLOOR.format(floor=floor, rest=rest))
    return {(one.field, one.message) for one in trial.notices if "cannot reach" in one.message}


def problems(floor, rest):
    with pytest.raises(sim.TrialError) as error:
        sim.Trial.parse(FLOOR.format(floor=floor, rest=rest))
    return {one.field: one for one in error.value.problems}


@pytest.mark.parametrize(
    ("floor", "key"),
    [
        ("zones: {shut: {x: [1, 6], y: [4, 10], forbidden: true, concerns: [cart]}}", "at"),
        (
            "zones: {shut: {x: [18, 24], y: [4, 10], forbidden: true, concerns: [c*]}}",
            "missions[0].go",
        ),
        (
            "zones: {shut: {x: [11, 13], y: [0, 14], forbidden: true, concerns: [cart]}}",
            "missions[0].go",
        ),
        (
            "gates: {shut: {between: [[12, 0], [12, 14]], towards: [5, 7], concerns: [cart]}}",
            "missions[0].go",
        ),
    ],
)
def test_a_place_forbidden_to_a_vehicle_is_an_error_at_its_line(floor, key):
    reported = problems(floor, CART)
    assert reported.keys() == {f"machines.cart.{key}"}
    assert reported[f"machines.cart.{key}"].line is not None


@pytest.mark.parametrize(
    "floor",
    [
        "zones: {shut: {x: [1, 6], y: [4, 10], forbidden: true, concerns: [ann]}}",
        "gates: {shut: {between: [[12, 0], [12, 14]], towards: [20, 7], concerns: [cart]}}",
    ],
)
def test_a_place_forbidden_to_others_and_a_gate_forwards_are_allowed(floor):
    sim.Trial.parse(FLOOR.format(floor=floor, rest=CART))


def test_a_move_of_an_agv_of_the_trial_into_a_forbidden_zone_is_an_error():
    zone = "zones: {shut: {x: [18, 24], y: [4, 10], forbidden: true, concerns: [tug]}}"
    rest = (
        "machines: {tug: {kind: agv, origin: [3, 7], limits: [0, 18], locations: {end: 18},"
        " moves: [{time: 1, to: end}]}}"
    )
    ((place, problem),) = problems(zone, rest).items()
    assert place.startswith("machines.tug")
    assert "forbidden to tug" in problem.message
    sim.Trial.parse(FLOOR.format(floor=zone.replace("[tug]", "[ann]"), rest=rest))


@pytest.mark.parametrize(
    "floor",
    [
        WALL,
        "zones: {shut: {x: [11, 13], y: [0, 14], forbidden: true, concerns: [ann]}}",
        "gates: {shut: {between: [[12, 0], [12, 14]], towards: [5, 7]}}",
        "doors: {shut: {between: [[12, 0], [12, 14]], open: false}}",
    ],
)
def test_a_station_that_a_person_may_choose_and_cannot_reach_is_a_notice(floor):
    assert notices(floor, "people: [{name: ann}]") == {("people[0]", "ann cannot reach b")}


def test_a_station_in_reach_needs_no_notice():
    opened = "doors: {shut: {between: [[12, 0], [12, 14]], open: false}}"
    assert not notices(opened, "people: [{name: ann}]\ndoors: {shut: {open: [[5, 15]]}}")
    assert not notices("", "people: [{name: ann}]")
    assert not notices(WALL, "people: [{name: ann, personality: external}]")
    employed = (
        "people: [{name: ann, personality: worker, schedule: [{time: 1, at: a, duration: 3}]}]"
    )
    assert not notices(WALL, employed)
    # After a violation the person is in the safe zone, from which the other station is in reach.
    teleported = FLOOR.replace("observe", "paper").replace("[3, 3]", "[21, 3]")
    trial = sim.Trial.parse(teleported.format(floor=WALL, rest="people: [{name: ann, at: a}]"))
    assert not any("cannot reach" in one.message for one in trial.notices)


@pytest.mark.parametrize(
    ("rest", "place"),
    [
        (
            "people: [{name: ann, schedule: [{time: 1, at: b, duration: 3}]}]",
            "people[0].schedule[0]",
        ),
        ("people: [{name: ann, breaks: [{time: 1, at: b, duration: 3}]}]", "people[0].breaks[0]"),
        ("people: [{name: ann, personality: visitor, sink: b}]", "people[0].sink"),
        ("people: [{name: ann}]\ncommands: [{time: 3, send: ann, to: [21, 8]}]", "commands[0].to"),
        (
            "people: [{name: ann, work: feed}]\n"
            "work: {feed: [{at: a, duration: 3}, {at: b, duration: 3}]}",
            "work.feed",
        ),
    ],
)
def test_a_goal_that_the_trial_names_is_an_error(rest, place):
    ((field, problem),) = problems(WALL, rest).items()
    assert field.startswith(place)
    assert "ann cannot reach" in problem.message
    assert problem.line is not None


def test_a_task_that_some_workers_reach_is_a_notice_for_the_others():
    rest = (
        "people: [{name: ann, personality: worker, work: feed},"
        " {name: bob, at: [20, 5], personality: worker, work: feed}]\n"
        "work: {feed: [{at: b, duration: 3}]}"
    )
    assert notices(WALL, rest) == {("people[0]", "ann cannot reach b")}


def test_terminal_and_report_name_it(floorwalker, tmp_path):
    file = tmp_path / "cut.trial.yaml"
    file.write_text(FLOOR.format(floor=WALL, rest="people: [{name: ann}]"))
    done = floorwalker("run", file, "--out", tmp_path / "out")
    assert "ann cannot reach b" in done.stderr
    assert floorwalker("check", file).returncode == 0
    for source in (tmp_path / "out", file):
        page = tmp_path / "report.html"
        assert floorwalker("report", source, "--out", page).returncode == 0
        assert page.read_text().count("ann cannot reach b") == 1
