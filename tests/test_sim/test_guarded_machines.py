"""Protective fields in trials stop and slow machines, regardless of commands."""

import math
import textwrap
from dataclasses import replace

import numpy as np
import pytest
from run_events import events, record
from small_floors import GANTRY, LANE, on_floor

import navigation
import sim
from sim.record.stops import machine_times
from sim.views.replay_data import replay_data

FLOOR = """\
boundary: [[0, 0], [30, 0], [30, 12], [0, 12]]
stations: {east: [27, 3], west: [3, 3]}
safe_zone: {at: [15, 3]}
human: {radius: 0.3}
"""
CONTROLLERS = """
import math, navigation

def stubborn(machine):
    machine.interrupt_on("disabled")
    while machine.position[0] < 26.9:
        try:
            yield machine.move_to(27.0, 3.0, 0.0)
        except Exception:
            yield machine.move_to(27.0, 3.0, 0.0)

def cheating(machine):
    machine.move_to(27.0, 3.0, 0.0)
    while not machine.disabled:
        yield machine.until(machine.now + 0.1)
    machine.hold(False)

def following(machine):
    while machine.position[0] < 26.9:
        if machine.disabled:
            yield machine.wait(0.1)
        else:
            yield machine.follow(machine.preview(27.0, 3.0, 0.0))

def forwards(machine):
    return (1.0, 0.0)
"""
FIELDS = """\
fields:
  fork:
    response_time: 0.2
    restart_delay: 2
    warning_speed: 0.3
    sets:
    - name: all
      protective: [[2.5, 0.8], [-0.8, 0.8], [-0.8, -0.8], [2.5, -0.8]]
      warning: [[4.5, 0.8], [-0.8, 0.8], [-0.8, -0.8], [4.5, -0.8]]
"""
FRONT, RADIUS = 2.5, 0.3


def trial(people="[]", more="missions: [{go: east}]", fields=FIELDS, keys="", folder=".", at=3.0):
    """Return a trial with a vehicle that drives east on y = 3."""
    text = f"""
    duration: 60
    rules: observe
    people: {people}
    machines:
      fork: {{kind: amr, at: [{at}, 3.0, 0.0], size: [1.2, 0.8], max_speed: 1.0, {more}}}
    """
    text = on_floor(FLOOR, textwrap.dedent(text)) + fields + keys
    return sim.Trial.parse(text, folder=folder)


def standing(x, y=3.0, max_speed=0.1):
    return f"[{{name: eve, personality: external, at: [{x}, {y}], max_speed: {max_speed}}}]"


LEAVES = "commands: [{time: 30, send: eve, to: [15, 9]}]\n"
ONLY_PROTECTIVE = FIELDS[: FIELDS.index("      warning")]


def from_field(run, t):
    """Return the distance of the person from the protective field on the left and ahead."""
    eve, fork = (run.motions[name].position(t) for name in ("eve", "fork"))
    ahead, beside = eve - fork - [FRONT, 0.8]
    return math.hypot(max(0.0, ahead), max(0.0, beside))


def test_a_machine_stops_after_the_response_time_and_restarts_after_the_delay():
    run = sim.run(trial(standing(15), fields=ONLY_PROTECTIVE, keys=LEAVES))
    motion = run.motions["fork"]
    (occupied,) = events(run, "field_occupied")
    assert (occupied["person"], occupied["field"], occupied["set"]) == ("eve", "protective", "all")
    assert from_field(run, occupied["t"]) == pytest.approx(RADIUS, abs=1e-6)
    (stop,) = events(run, "field_stop")
    assert stop["t"] == pytest.approx(occupied["t"] + 0.2, abs=1e-9)
    assert (stop["cause"], stop["person"]) == ("intrusion", "eve")
    assert motion.state(stop["t"]).speed == pytest.approx(1.0)
    braking = navigation.vehicle_stop(motion.state(stop["t"]), stop["t"])
    stands = motion.position(braking.end + 1e-6)
    assert np.allclose(motion.position(np.linspace(braking.end + 1e-6, 30.0, 9)), stands)
    (free,), (ended,) = events(run, "field_free"), events(run, "field_stop_ended")
    assert from_field(run, free["t"]) == pytest.approx(RADIUS, abs=1e-6)
    assert ended["t"] == pytest.approx(free["t"] + 2.0, abs=1e-9)
    assert motion.state(ended["t"] + 1.0).speed > 0.0
    assert len(events(run, "job_done")) == 1 and run.summary["contacts"] == 0


def test_figures_are_those_of_the_events_and_can_be_expected(tmp_path):
    keys = LEAVES + (
        "expect: {field_stops: 1, machines.fork.field_stops: 1,"
        " machines.fork.field_stop_time: '< 40', field_slow_time: '> 1'}\n"
    )
    run = record(trial(standing(15), keys=keys), tmp_path)
    assert all(verdict.met for verdict in run.verdicts)
    mine = run.summary["machines"]["fork"]
    for figure in ("field_stops", "field_stop_time", "field_slow_time"):
        assert run.summary[figure] == mine[figure]
    begin, end = (events(run, kind)[0]["t"] for kind in ("field_stop", "field_stop_ended"))
    assert mine["field_stop_time"] == pytest.approx(end - begin)
    slow, fast = (events(run, kind)[0]["t"] for kind in ("field_slowdown", "field_slowdown_ended"))
    assert mine["field_slow_time"] == pytest.approx(fast - slow - (end - begin))
    assert sim.load_run(tmp_path).scene.fields == run.trial.fields


@pytest.mark.parametrize("name", ["stubborn", "following", "forwards"])
def test_no_controller_drives_on(tmp_path, name):
    (tmp_path / "mine.py").write_text(CONTROLLERS)
    more = f"controller: 'mine:{name}'" + (", rate: 10" if name == "forwards" else "")
    run = sim.run(trial(standing(15), more, ONLY_PROTECTIVE, folder=tmp_path))
    (stop,) = events(run, "field_stop")
    motion = run.motions["fork"]
    stands = motion.position(stop["t"] + 4.0)
    assert 11.0 < stands[0] < 15.0 - RADIUS - 0.6
    assert motion.position(60.0) == pytest.approx(stands, abs=1e-9)


def test_a_controller_that_ends_the_stop_ends_the_run(tmp_path):
    (tmp_path / "mine.py").write_text(CONTROLLERS)
    made = trial(standing(15), "controller: 'mine:cheating'", ONLY_PROTECTIVE, folder=tmp_path)
    with pytest.raises(ValueError, match=r"'fork' drives on at .* no controller can switch off"):
        sim.run(made)


@pytest.mark.parametrize("name", ["", "forwards"])
def test_the_warning_field_limits_the_speed(tmp_path, name):
    (tmp_path / "mine.py").write_text(CONTROLLERS)
    more = f"controller: 'mine:{name}', rate: 10" if name else "missions: [{go: east}]"
    # The person stands beside the course, so that only the warning field reaches them.
    fields = FIELDS.replace("[[4.5, 0.8]", "[[4.5, 2.0]")
    run = sim.run(trial(standing(15, 4.5), more, fields, folder=tmp_path))
    motion = run.motions["fork"]
    (slow,), (fast,) = events(run, "field_slowdown"), events(run, "field_slowdown_ended")
    (occupied,), (free,) = events(run, "field_occupied"), events(run, "field_free")
    assert (occupied["field"], free["field"]) == ("warning", "warning")
    assert slow["t"] == pytest.approx(occupied["t"] + 0.2)
    assert fast["t"] == pytest.approx(free["t"] + 2.0)
    times = np.linspace(slow["t"] + 2.0, fast["t"], 200)
    speeds = np.hypot(*motion.velocity(times).T)
    assert speeds.max() <= 0.3 + 1e-6 and speeds.min() > 0.2
    assert motion.state(slow["t"]).speed == pytest.approx(1.0, abs=1e-3)
    later = np.hypot(*motion.velocity(np.linspace(fast["t"], fast["t"] + 4.0, 50)).T)
    assert later.max() > 0.9
    assert run.summary["field_stops"] == 0


def test_a_followed_motion_that_is_too_fast_is_stopped_by_the_warning_field(tmp_path):
    (tmp_path / "mine.py").write_text(CONTROLLERS)
    fields = FIELDS.replace("[[4.5, 0.8]", "[[4.5, 2.0]")
    keys = "commands: [{time: 30, send: eve, to: [15, 11]}]\n"
    run = sim.run(trial(standing(15, 4.5), "controller: 'mine:following'", fields, keys, tmp_path))
    (slow,), (fast,) = events(run, "field_slowdown"), events(run, "field_slowdown_ended")
    motion = run.motions["fork"]
    assert motion.state(slow["t"] + 3.0).speed == 0.0 and fast["t"] > 30.0
    assert motion.position(60.0)[0] == pytest.approx(27.0)


def test_holders_are_counted():
    keys = "commands: [{time: 13, hold: fork}, {time: 50, release: fork}]\n"
    stays = sim.run(trial(standing(15), fields=ONLY_PROTECTIVE, keys=keys))
    assert stays.motions["fork"].state(59.0).speed == 0.0
    keys = keys.replace("{time: 50", "{time: 16, send: eve, to: [15, 9]}, {time: 50")
    run = sim.run(trial(standing(15), fields=ONLY_PROTECTIVE, keys=keys))
    (ended,) = events(run, "field_stop_ended")
    assert ended["t"] < 30.0
    motion = run.motions["fork"]
    assert motion.state(49.9).speed == 0.0 and motion.state(51.0).speed > 0.0


def test_a_person_in_the_field_at_the_start_prevents_the_machine_from_starting():
    run = sim.run(
        trial(standing(5, max_speed=1.0), keys="commands: [{time: 10, send: eve, to: [15, 9]}]\n")
    )
    assert events(run, "field_stop")[0]["t"] == 0.0
    (ended,) = events(run, "field_stop_ended")
    assert np.allclose(run.motions["fork"].position(np.linspace(0, ended["t"], 50)), [3.0, 3.0])
    assert len(events(run, "job_done")) == 1


def test_a_person_who_is_put_into_the_field_stops_the_machine(tmp_path):
    (tmp_path / "jumper.asl").write_text("+human_start <- .wait(9000); teleport_safe.\n")
    people = "[{name: eve, personality: jumper.asl, at: [5, 10]}]"
    fields = ONLY_PROTECTIVE.replace("[2.5, 0.8]", "[6.5, 3.0]").replace("[2.5, -", "[6.5, -")
    run = sim.run(trial(people, folder=tmp_path, fields=fields))
    (stop,), (occupied,) = events(run, "field_stop"), events(run, "field_occupied")
    (jumped,) = events(run, "teleport")
    assert occupied["t"] == jumped["t"] == 9.0
    assert stop["t"] == pytest.approx(9.2)


def test_a_turn_on_the_spot_sweeps_the_field_over_a_person():
    run = sim.run(trial(standing(10, 5.2), "missions: [{turn: 3.0}]", ONLY_PROTECTIVE, at=10.0))
    (occupied,), (stop,) = events(run, "field_occupied"), events(run, "field_stop")
    state = run.motions["fork"].state(occupied["t"])
    assert state.speed == 0.0 and state.velocity[2] > 0.0
    c, s = math.cos(state.position[2]), math.sin(state.position[2])
    x, y = 2.2 * s, 2.2 * c
    apart = math.hypot(max(0.0, x - FRONT), max(0.0, abs(y) - 0.8))
    assert apart == pytest.approx(RADIUS, abs=1e-6)
    turned = run.motions["fork"].rotation(60.0)
    assert run.motions["fork"].rotation(stop["t"]) < turned < 3.0


def test_muting_by_zone_and_an_intrusion_at_its_end():
    floor = "zones: {dock: {x: [10, 14], y: [0, 6], max_speed: 3.0}}\n"
    fields = ONLY_PROTECTIVE + "    muting: [dock]\n"
    text = on_floor(
        FLOOR + floor,
        f"duration: 60\nrules: observe\npeople: {standing(13.4, 3.9)}\nmachines:\n"
        "  fork: {kind: amr, at: [3, 3, 0], size: [1.2, 0.8], max_speed: 1.0,"
        " missions: [{go: east}]}\n",
    )
    run = sim.run(sim.Trial.parse(text + fields))
    motion = run.motions["fork"]
    (muted,), (unmuted,) = events(run, "fields_muted"), events(run, "fields_unmuted")
    assert motion.position(muted["t"])[0] == pytest.approx(10.0, abs=1e-6)
    assert motion.position(unmuted["t"])[0] == pytest.approx(14.0, abs=1e-6)
    (occupied,), (stop,) = events(run, "field_occupied"), events(run, "field_stop")
    assert occupied["t"] == unmuted["t"] and stop["t"] == pytest.approx(unmuted["t"] + 0.2)


def test_fields_are_not_muted_in_a_hole_of_a_zone():
    floor = (
        "zones: {dock: {polygon: [[10, 0], [20, 0], [20, 6], [10, 6]], max_speed: 3.0,"
        " holes: [[[12, 1], [15, 1], [15, 5], [12, 5]], [[16, 1], [17, 1], [17, 2], [16, 2]]]}}\n"
    )
    text = on_floor(
        FLOOR + floor,
        "duration: 60\nrules: observe\npeople: []\nmachines:\n"
        "  fork: {kind: amr, at: [3, 3, 0], max_speed: 1.0, missions: [{go: east}]}\n",
    )
    run = sim.run(sim.Trial.parse(text + ONLY_PROTECTIVE + "    muting: [dock]\n"))
    motion = run.motions["fork"]
    changes = [
        (e["kind"], float(motion.position(e["t"])[0]))
        for e in run.events
        if e["kind"] in ("fields_muted", "fields_unmuted")
    ]
    assert changes == [
        ("fields_muted", pytest.approx(10.0, abs=1e-6)),
        ("fields_unmuted", pytest.approx(12.0, abs=1e-6)),
        ("fields_muted", pytest.approx(15.0, abs=1e-6)),
        ("fields_unmuted", pytest.approx(20.0, abs=1e-6)),
    ]


def test_muting_by_time():
    fields = ONLY_PROTECTIVE + "    muting: {times: [[0, 5], [20]]}\n"
    run = sim.run(trial(standing(4.5, 4.3), fields=fields))
    assert [e["t"] for e in events(run, "fields_muted")] == [0.0, 20.0]
    assert [e["t"] for e in events(run, "fields_unmuted")] == [5.0]
    assert len(events(run, "job_done")) == 1


def test_a_blackout_stops_the_machine():
    keys = "blackouts: [{machine: fork, start: {time: 6}, seconds: 4}]\n"
    run = sim.run(trial(fields=FIELDS, keys=keys))
    (stop,), (ended,) = events(run, "field_stop"), events(run, "field_stop_ended")
    assert (stop["t"], stop["cause"]) == (6.2, "blackout") and "person" not in stop
    assert ended["t"] == 12.0
    (times,) = (one for one in machine_times(run) if one.machine == "fork")
    assert 2.0 < times.stopped["blackout"] < 12.0 - 6.2


def test_a_velocity_without_field_set_stops_the_machine():
    fields = FIELDS.replace("- name: all\n", "- name: all\n      linear: [-1, 0.5]\n")
    made = trial(fields=fields, keys="")
    assert any("0.5 to 1 m/s" in notice.message for notice in made.notices)
    run = sim.run(made)
    stops = events(run, "field_stop")
    assert {stop["cause"] for stop in stops} == {"no field set"} and len(stops) > 5
    speeds = np.hypot(*run.motions["fork"].velocity(np.linspace(0, 60, 3000)).T)
    assert 0.5 < speeds.max() < 0.75


def test_sets_by_load():
    fields = FIELDS.replace("- name: all\n", "- name: all\n      load: true\n")
    run = sim.run(trial(standing(15), "missions: [{go: east}], load: [1, 0.8, 0.5]", fields))
    assert {event["set"] for event in events(run, "field_occupied")} == {"all"}


def test_stops_of_a_vehicle_have_persons_and_causes():
    more = "missions: [{wait: 3}, {go: east}]"
    run = sim.run(trial(standing(15), more, ONLY_PROTECTIVE, LEAVES))
    (times,) = (one for one in machine_times(run) if one.machine == "fork")
    assert times.moving + sum(times.stopped.values()) == pytest.approx(60.0)
    causes = {cause for cause, seconds in times.stopped.items() if seconds > 1e-6}
    assert causes == {"protective field", "job wait", "nothing to do"}
    ((key, (count, seconds)),) = times.whom.items()
    assert key == ("protective field", "eve") and count == 1
    assert seconds == pytest.approx(times.stopped["protective field"])
    assert times.had_jobs and times.jobs_done == 2


def test_agvs_stop_and_slow():
    text = on_floor(
        FLOOR + LANE,
        f"duration: 60\nrules: observe\npeople: {standing(10, 4.5, 0.05)}\n"
        "agvs: {cart: [{time: 0, to: east}]}\n",
    ) + FIELDS.replace("fork", "cart").replace("[[4.5, 0.8]", "[[4.5, 2.0]")
    run = sim.run(sim.Trial.parse(text))
    (slow,), (fast,) = events(run, "field_slowdown"), events(run, "field_slowdown_ended")
    motion = run.motions["cart"]
    assert motion.state(slow["t"] + 2.0).speed == pytest.approx(0.3)
    assert motion.state(fast["t"] + 2.0).speed > 0.9
    stopped = sim.run(sim.Trial.parse(text.replace("[10, 4.5]", "[10, 3.5]")))
    (stop,) = events(stopped, "field_stop")
    assert stopped.motions["cart"].state(stop["t"] + 3.0).speed == 0.0
    assert stopped.summary["machines"]["cart"]["field_stops"] == 1
    assert stopped.summary["contacts"] == 0


@pytest.mark.parametrize("controller", ["oblivious", "avoiding"])
def test_gantries_stop_and_slow(controller):
    corners = "[[{0}, 1], [-1, 1], [-1, -1], [{0}, -1]]"
    text = on_floor(
        FLOOR + GANTRY,
        "duration: 60\nrules: {based_on: observe, gantry_law: {fixed: 0.1}}\n"
        f"people: {standing(14, 8)}\n"
        f"gantry: {{at: [4, 8, 0], controller: {controller}, jobs: [{{move: [18, 8, 0]}}]}}\n"
        "fields: {gantry: {sets: [{name: all, protective: "
        f"{corners.format(3)}, warning: {corners.format(5)}}}]}}}}\n",
    )
    run = sim.run(sim.Trial.parse(text))
    motion = run.motions["gantry"]
    (slow, *_), (stop, *_) = events(run, "field_slowdown"), events(run, "field_stop")
    assert motion.state(stop["t"] - 1e-3).speed < 0.35 or stop["t"] - slow["t"] < 1.6
    stands = motion.position(stop["t"] + 3.0)
    assert motion.position(60.0) == pytest.approx(stands, abs=1e-9)
    assert stands[0] < 14.0


def test_both_fields_stop_a_custom_machine(tmp_path):
    (tmp_path / "own.py").write_text(
        textwrap.dedent(
            """
            from dataclasses import dataclass
            import navigation, sim

            @dataclass(frozen=True)
            class Sled(sim.MachineModel):
                def shape(self, name, plan):
                    return sim.MachineShape(name=name, kind="sled", category="vehicle", length=1.2,
                        width=0.8, top=0.4, top_speed=1.0)
                def make(self, name, stage):
                    return Running(self, name, stage)

            class Running(sim.Machine):
                def __init__(self, model, name, stage):
                    self.shape, self.stage = model.shape(name, stage.floorplan), stage
                    at = navigation.standing((3.0, 3.0), start=stage.clock.now)
                    self.body = sim.Body(stage.clock, name, "sled", at)
                def begin(self):
                    self.hold(False)
                def hold(self, stands):
                    state, now = self.body.state, self.stage.clock.now
                    if stands:
                        self.body.follow(navigation.vehicle_stop(state, now))
                    else:
                        limits = navigation.VehicleLimits(speed=1.0)
                        self.body.follow(
                            navigation.vehicle_segment(state, (27.0, 3.0), now, limits=limits))
            """
        )
    )
    text = on_floor(
        FLOOR,
        f"duration: 60\nrules: observe\npeople: {standing(15)}\n"
        "machines: {fork: {kind: 'own:Sled'}}\n",
    )
    run = sim.run(sim.Trial.parse(text + FIELDS + LEAVES.replace("30", "25"), folder=tmp_path))
    (slow,), motion = events(run, "field_slowdown"), run.motions["fork"]
    assert motion.state(slow["t"] + 3.0).speed == 0.0
    assert motion.position(slow["t"] + 3.0)[0] == pytest.approx(15 - 4.5 - RADIUS + 1.0, abs=0.5)
    (times,) = (one for one in machine_times(run) if one.machine == "fork")
    assert times.stopped["warning field"] > 10.0
    assert motion.position(60.0)[0] == pytest.approx(27.0)


def test_a_trial_without_fields_records_none(tmp_path):
    record(trial(standing(15), fields=""), tmp_path)
    assert '"fields"' not in (tmp_path / "scene.json").read_text()
    assert '"field_stops"' not in (tmp_path / "summary.json").read_text()


def test_fields_can_be_given_in_python_and_are_written(tmp_path):
    square = ((2.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (2.0, -1.0))
    slow = navigation.FieldSet(name="slow", protective=square, linear=(-math.inf, 0.5))
    turned = navigation.FieldSet(name="turned", protective=square, theta=(0.1, 1.0), load=False)
    fields = sim.MachineFields(
        sets=(slow, turned), muting=sim.Muting(times=((1.0, 2.0), (4.0, math.inf)))
    )
    text = trial(fields="").to_yaml(tmp_path)
    made = sim.Trial.parse(text, folder=tmp_path)
    made = replace(made, fields={"fork": fields})
    again = sim.Trial.parse(made.to_yaml(tmp_path), folder=tmp_path)
    assert again.fields["fork"].sets[1] == turned
    assert again.fields["fork"].sets[0].linear == (-1e10, 0.5)
    assert again.fields["fork"].muting == fields.muting
    runs = [sim.run(one) for one in (again, made)]
    recorded_events = [[event for event in run.events if event["kind"] != "notice"] for run in runs]
    assert recorded_events[0] == recorded_events[1]


CORNERS = "[[2, 1], [-2, 1], [-2, -1], [2, -1]]"
WRONG = {
    "fork: {sets: []}": "fields.fork.sets: sets must have a field set",
    "fork: {response_time: 1}": "fields.fork.sets: is missing",
    f"frok: {{sets: [{{name: a, protective: {CORNERS}}}]}}": "no machine is called 'frok'; did you",
    "fork: {sets: [{name: a, protective: [[1, 1], [2, 2]]}]}": "protective: must have 3 corners",
    "fork: {sets: [{name: a, protective: [[1, 1], [-1, -1], [1, -1], [-1, 1]]}]}": (
        "fields.fork.sets[0].protective: is not a simple polygon: edges cross"
    ),
    f"fork: {{sets: [{{name: a, protective: {CORNERS}, warning: [[1, 1], [-1, 1], [0, -1]]}}]}}": (
        "fields.fork.sets[0].warning: does not contain the protective field"
    ),
    f"fork: {{sets: [{{name: a, protective: {CORNERS}, linear: [1, 0.5]}}]}}": (
        "fields.fork.sets[0].linear: must be [low, high]"
    ),
    f"fork: {{sets: [{{name: a, protective: {CORNERS}}}], muting: [dokc]}}": (
        "fields.fork.muting.zones[0]: no zone is called 'dokc'"
    ),
    f"fork: {{sets: [{{name: a, protective: {CORNERS}}}], muting: {{times: [[4, 2]]}}}}": (
        "fields.fork.muting.times[0]: ends before it begins"
    ),
    f"fork: {{sets: [{{name: a, protective: {CORNERS}}}], restart_delay: 0.001}}": (
        "fields.fork.restart_delay: must be at least 0.01 s, not 0.001"
    ),
    f"fork: {{sets: [{{name: a, protectiv: {CORNERS}}}]}}": "did you mean 'protective'?",
}


@pytest.mark.parametrize("fields", WRONG)
def test_errors_name_the_field(fields):
    with pytest.raises(sim.TrialError) as why:
        trial(fields=f"fields: {{{fields}}}\n")
    assert WRONG[fields] in str(why.value) and "line" in str(why.value)
    assert len(why.value.problems) <= 2


def test_fields_that_are_too_short_cause_a_notice():
    fields = f"fields: {{fork: {{sets: [{{name: a, protective: {CORNERS}}}]}}}}\n"
    fields = fields.replace("[2,", "[1,")
    short = [notice for notice in trial(fields=fields).notices if "too short" in notice.message]
    assert {notice.field for notice in short} == {"fields.fork.sets[0].protective"}
    longer = fields.replace("[1,", "[4,").replace("[-2,", "[-4,")
    arcs = [notice for notice in trial(fields=longer).notices if "too short" in notice.message]
    assert arcs and all(" on an arc to the " in notice.message for notice in arcs)
    longer = longer.replace(", 1]", ", 1.5]").replace(", -1]", ", -1.5]")
    assert not [notice for notice in trial(fields=longer).notices if "short" in notice.message]


def test_the_replay_has_the_sets_of_a_machine():
    fields = FIELDS.replace("- name: all\n", "- name: all\n      linear: [-1.0, 1.0]\n")
    made = replay_data(sim.run(trial(fields=fields)))
    (fork,) = (body for body in made["bodies"] if body["name"] == "fork")
    (one,) = fork["fields"]
    assert (one["name"], one["linear"], one["theta"]) == ("all", [-1.0, 1.0], [None, None])
    assert tuple(one["warning"][0]) == (4.5, 0.8)


def field_notices(vehicle, sets, **keys):
    text = f"""
floorplan: {{boundary: [[0, 0], [40, 0], [40, 40], [0, 40]], stations: {{a: [3, 3]}}}}
duration: 60
rules: observe
machines:
  cart: {{kind: amr, at: [3, 3, 0], {vehicle}}}
fields: {{cart: {{sets: {sets}}}}}
"""
    notices = sim.Trial.parse(text).notices
    return [(one.field, one.message) for one in notices if one.field.startswith("fields")]


WIDE = "protective: [[4, -4], [4, 4], [-4, 4], [-4, -4]]"


@pytest.mark.parametrize(
    ("vehicle", "sets"),
    [
        ("drive: holonomic", f"[{{name: all, linear: [-1.5, 1.5], {WIDE}}}]"),
        (
            "drive: holonomic, max_side_speed: 0.3",
            f"[{{name: all, linear: [0, 1.53], direction: [-1, 1], {WIDE}}},"
            f" {{name: back, linear: [0, 1.53], direction: [2, 4.3], {WIDE}}},"
            f" {{name: side, linear: [0, 0.4], direction: [-3.14159, 3.14159], {WIDE}}}]",
        ),
        (
            "max_turn_speed: 0.5",
            f"[{{name: ahead, linear: [0, 1.5], direction: [-0.1, 0.1], {WIDE}}},"
            f" {{name: back, linear: [0, 1.5], direction: [3.1, 3.2], {WIDE}}}]",
        ),
    ],
)
def test_velocities_that_cannot_occur_need_no_set(vehicle, sets):
    assert field_notices(vehicle, sets) == []


def test_a_direction_without_a_set_causes_a_notice():
    sets = f"[{{name: ahead, linear: [0, 1.5], direction: [-0.1, 0.1], {WIDE}}}]"
    ((place, message),) = field_notices("max_turn_speed: 0.5", sets)
    assert place == "fields.cart.sets"
    assert "direction 3.14" in message


@pytest.mark.parametrize("rest", ["linear: [-2, 2], ", "", "linear: [0.2, 0.4], "])
def test_a_set_behind_others_never_applies(rest):
    tight = "protective: [[0.7, 0.5], [0.7, -0.5], [-0.7, -0.5], [-0.7, 0.5]]"
    sets = (
        f"[{{name: forward, linear: [0, 2], {WIDE}}}, {{name: backward, linear: [-2, 0], {WIDE}}},"
        f" {{name: stopped, {rest}{tight}}}]"
    )
    ((place, message),) = field_notices("max_speed: 1.5", sets)
    assert place == "fields.cart.sets[2]"
    assert "never applies" in message
