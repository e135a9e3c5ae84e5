"""Studies that vary any value of a trial by its path."""

import pytest

import sim

TRIAL = """\
floorplan: ariac2023
duration: 12
people:
  - {name: eve, noticing: {field_of_view: 120}}
  - {name: max, at: [-14, -9]}
gantry: {controller: oblivious, jobs: [{move: [-9, 2, 0]}]}
machines: {north: {kind: gantry, at: [-13.0, -4.0, 0.0], x: [-14.0, -8.0]}}
"""


FIELDS = """\
floorplan: {boundary: [[0, 0], [24, 0], [24, 8], [0, 8]]}
duration: 12
rules: observe
people: [{name: eve, personality: external, at: [14, 4], max_speed: 0.1}]
machines:
  fork: &fork {kind: amr, at: [2, 4, 0], missions: [{go: [22, 4, 0]}]}
  cart: {<<: *fork, at: [2, 2, 0], missions: []}
fields:
  fork: &fields
    sets: [{name: all, protective: [[4, 0.7], [-1, 0.7], [-1, -0.7], [4, -0.7]]}]
  cart: *fields
"""


def study(tmp_path, grid, trial=TRIAL):
    (tmp_path / "one.trial.yaml").write_text(trial)
    return sim.Study.parse(f"trials: [one.trial.yaml]\ngrid:\n{grid}", folder=tmp_path)


def test_fields_of_one_machine_or_of_all_are_varied(tmp_path):
    grid = "  fields.fork.response_time: [0.1, 0.4]\n  fields.*.restart_delay: [3.0]\n"
    rows = [row.trial for row in study(tmp_path, grid, FIELDS).rows()]
    assert [one.fields["fork"].response_time for one in rows] == [0.1, 0.4]
    assert {one.fields["cart"].response_time for one in rows} == {0.2}
    assert {fields.restart_delay for one in rows for fields in one.fields.values()} == {3.0}
    runs = [sim.run(one) for one in rows]
    began = [next(e["t"] for e in one.events if e["kind"] == "field_stop") for one in runs]
    assert began[1] - began[0] == pytest.approx(0.3, abs=1e-6)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("fields.fork.response: [0.1]", "did you mean 'response_time'"),
        ("fields.truck.response_time: [0.1]", "there is no 'truck'"),
        ("fields.fork.sets.fast.theta: [1]", "there is no 'fast'"),
        ("fields.fork.restart_delay: [0.001]", "must be at least 0.01 s, not 0.001"),
    ],
)
def test_unknown_fields_are_rejected(tmp_path, path, message):
    with pytest.raises(ValueError, match=message):
        study(tmp_path, f"  {path}\n", FIELDS)


def test_every_row_has_the_values_of_its_parameters(tmp_path):
    made = study(
        tmp_path,
        "  rules.gantry_law.t1: [0.5, 1.5]\n"
        "  gantry.max_speed: [0.4, 1.0]\n"
        "  people.eve.noticing.field_of_view: [60, 200]\n"
        "  people.*.manners.comfort: [0.2]\n",
    )
    assert len(made) == 8
    for row in made.rows():
        t1, speed, view, comfort = (row.parameters[name.name] for name in made.grid)
        trial, base = row.trial, sim.Trial.load(tmp_path / "one.trial.yaml")
        assert trial.rules.gantry_law.t1 == trial.rules.notice.law.law.t1 == t1
        assert trial.rules.gantry_law.t2 == base.rules.gantry_law.t2
        assert trial.rules.agv_law == base.rules.agv_law
        assert [axis.max_speed for axis in trial.floorplan.gantry.axes[:2]] == [speed, speed]
        assert trial.floorplan.gantry.rotation == base.floorplan.gantry.rotation
        assert trial.people[0].noticing.field_of_view == view
        assert [person.manners.comfort for person in trial.people] == [comfort, comfort]
        again = sim.Trial.parse(trial.to_yaml(tmp_path), folder=tmp_path)
        assert again.rules == trial.rules and again.floorplan == trial.floorplan
        assert again.people == trial.people


def test_a_sweep_is_run_and_its_rows_differ(tmp_path):
    made = study(tmp_path, "  gantry.max_speed: [0.25, 1.0]\n")
    slow, fast = (sim.run(row.trial) for row in made.rows())
    done = [next(e["t"] for e in r.events if e["kind"] == "job_done") for r in (slow, fast)]
    assert done[0] > 2 * done[1]


DAY = """\
floorplan: {boundary: [[0, 0], [24, 0], [24, 8], [0, 8]], stations: {dock: [2, 2], shelf: [20, 6]}}
duration: 60
rules: observe
planner: RRTConnect
warm_up: 5
people:
  - {name: ann, at: [3, 3], work: picks, shifts: [[0, 50]]}
  - {name: bob, at: [6, 6], start: {event: arrived}}
work: {picks: [{at: dock, duration: 4, every: 30}, {at: shelf, duration: {uniform: [2, 5]}}]}
machines: {cart: {kind: agv, origin: [8, 1], limits: [0, 5], moves: [{time: 3, to: 4}]}}
blackouts:
  - {machine: cart, start: {time: 3}, seconds: 2}
  - {machine: cart, start: {time: 9}, seconds: 1}
obstacles: {box: {x: [12, 13], y: [4, 5], z: [0, 1], there: [[10, 20]]}}
commands: [{time: 7, send: ann, to: dock}]
"""


@pytest.mark.parametrize(
    ("path", "value", "changed"),
    [
        ("blackouts.0.start.time", 4.5, lambda t: t.blackouts[0].start.time),
        ("blackouts.*.seconds", 3.0, lambda t: t.blackouts[1].seconds),
        ("work.picks.0.every", 12.0, lambda t: t.work["picks"].tasks[0].every),
        ("work.picks.tasks.1.time", 6.0, lambda t: t.work["picks"].tasks[1].time),
        ("work.*.*.priority", 2, lambda t: t.work["picks"].tasks[1].priority),
        ("work.picks.0.at", "shelf", lambda t: t.work["picks"].tasks[0].at),
        ("people.ann.at.1", 2.5, lambda t: t.people[0].at[1]),
        ("people.0.at", "dock", lambda t: t.people[0].at),
        ("people.ann.shifts.0.1", 40.0, lambda t: t.people[0].shifts[0][1]),
        ("people.bob.start.count", 2, lambda t: t.people[1].start.count),
        ("machines.cart.moves.0.to", 2.0, lambda t: t.machines["cart"].keys["moves"][0]["to"]),
        ("obstacles.box.there.0.0", 11.0, lambda t: t.obstacles[0].there[0][0]),
        ("commands.0.time", 8.0, lambda t: t.commands[0].time),
        ("commands.0.to", "shelf", lambda t: t.commands[0].to),
        ("warm_up", 7.0, lambda t: t.warm_up),
        ("traffic", False, lambda t: t.traffic),
        (
            "floorplan.stations.shelf.position.0",
            19.0,
            lambda t: t.floorplan.stations[1].position[0],
        ),
    ],
)
def test_every_value_of_a_trial_is_varied_by_its_path(tmp_path, path, value, changed):
    trial = sim.Trial.parse(DAY, folder=tmp_path)
    row = study(tmp_path, f"  {path}: [{str(value).lower()}]\n", DAY).row(0)
    assert changed(trial) != value and changed(row.trial) == value
    sim.Trial.parse(row.trial.to_yaml(tmp_path), folder=tmp_path)


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("blackouts.2.seconds: [1]", "there is no '2'"),
        ("blackouts.*.second: [1]", "did you mean 'seconds'"),
        ("blackouts.0.seconds: [-1]", "must be more than 0|expected more than 0"),
        ("blackouts.0.seconds: [long]", "expected a number"),
        ("people.bob.start.time: [3]", "there is no 'time'"),
        ("people.ann.at.x: [3]", "there is no 'x'"),
        ("work.picks.0.at: [shelv]", "shelf"),
        ("seed: [1, 2]", "seeds are not varied"),
        ("weather: [1]", "'weather' to vary"),
    ],
)
def test_unknown_paths_and_invalid_values_are_rejected(tmp_path, path, message):
    with pytest.raises(ValueError, match=message):
        study(tmp_path, f"  {path}\n", DAY)


def test_real_numbers_are_not_drawn_for_keys_of_whole_numbers(tmp_path):
    (tmp_path / "one.trial.yaml").write_text(DAY)
    text = "trials: [one.trial.yaml]\nrandom: {work.picks.0.priority: {uniform: [1, 5]}}"
    with pytest.raises(ValueError, match="whole number"):
        sim.Study.parse(text, folder=tmp_path)


def test_trials_that_differ_only_in_a_controller_have_the_same_seeds(tmp_path):
    for name in ("pausing", "avoiding"):
        (tmp_path / f"{name}.trial.yaml").write_text(TRIAL.replace("oblivious", name))
    (tmp_path / "long.trial.yaml").write_text(TRIAL.replace("12", "13"))
    made = sim.Study.parse(
        "trials: [pausing.trial.yaml, avoiding.trial.yaml, long.trial.yaml]", folder=tmp_path
    )
    one, other, third = (row.trial.seed for row in made.rows())
    assert one == other != third
