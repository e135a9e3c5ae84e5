"""People at work: tasks, lists, schedules, shifts and breaks, and agents that decide about them."""

import pytest

import floorplan
import sim
from sim import Duration, WorkList, WorkTask

FLOOR = """\
floorplan:
  boundary: [[0, 0], [20, 0], [20, 10], [0, 10]]
  stations: {press: [2, 2], bench: [18, 2], canteen: [10, 8]}
  safe_zone: {at: [10, 2]}
"""


def trial(text, folder="."):
    return sim.Trial.parse(FLOOR + text, folder=folder)


def happened(run, *kinds):
    return [
        (round(e["t"], 1), e["kind"], e["person"], e.get("task"))
        for e in run.events
        if e["kind"] in kinds
    ]


def test_people_share_a_list_and_do_the_urgent_first():
    run = sim.run(
        trial("""\
duration: 100
people:
  - {name: ann, personality: worker, work: line}
  - {name: bob, personality: worker, work: line}
work:
  line:
    - {name: low, at: press, duration: 20}
    - {name: high, at: bench, duration: 10 s, priority: 2}
    - {name: late, at: press, duration: 5, time: 60}
""")
    )
    taken = happened(run, "task_taken")
    assert taken[:2] == [(0.0, "task_taken", "ann", "high"), (0.0, "task_taken", "bob", "low")]
    assert taken[2][::3] == (60.0, "late")
    done = [e for e in run.events if e["kind"] == "task_done"]
    assert [(e["task"], round(e["took"], 6)) for e in done] == [
        ("high", 10.0),
        ("low", 20.0),
        ("late", 5.0),
    ]
    assert run.summary["tasks_done"] == 3
    ann = run.summary["people"]["ann"]
    assert ann["throughput"] == pytest.approx(ann["tasks_done"] * 36)
    assert sum(p["time_working"] for p in run.summary["people"].values()) == pytest.approx(35)


def test_shifts_breaks_and_schedules_by_the_clock():
    run = sim.run(
        trial("""\
duration: 1200
begins: 05:50
people:
  - name: ann
    personality: worker
    work: line
    shifts: [06:00 - 06:08]
    schedule: ["06:01 bench for 1 min"]
    breaks: [06:04 canteen for 2 min]
work:
  line: {tasks: [{at: press, duration: 25}], repeat: true}
""")
    )
    kinds = ("shift_began", "shift_ended", "task_done")
    entries = happened(run, *kinds)
    assert entries[0] == (600.0, "shift_began", "ann", None)
    names = [task for _, kind, _, task in entries if kind == "task_done"]
    assert names.count("bench") == names.count("break") == 1
    times = {e["task"]: e for e in run.events if e["kind"] == "task_done"}
    assert times["break"]["t"] - times["break"]["took"] - times["break"]["waited"] == 840.0
    assert entries[-1][0] < 1080 + 25 + 30
    # Only work counts, not breaks. Throughput is per hour of the shift.
    ann = run.summary["people"]["ann"]
    assert ann["tasks_done"] == len(names) - 1
    assert ann["throughput"] == pytest.approx(ann["tasks_done"] / 480 * 3600)
    # After the shift she goes home.
    assert run.motions["ann"].position(1199.0)[:2] == pytest.approx([10, 2], abs=0.01)


def test_draws_do_not_depend_on_the_worker():
    def took(people):
        run = sim.run(
            trial(f"""\
duration: 400
people: [{people}]
work:
  line: [{{at: press, duration: {{lognormal: [10, 0.5]}}, every: 20, count: 6}}]
""")
        )
        done = [e for e in run.events if e["kind"] == "task_done"]
        return sorted(round(e["took"], 6) for e in done)

    ann = "{name: ann, personality: worker, work: line}"
    assert took(ann) == took(f"{ann}, {ann.replace('ann', 'bob')}")
    assert len(set(took(ann))) == 6


@pytest.mark.parametrize(
    ("kind", "values", "mean"),
    [
        ("fixed", (7.0,), 7.0),
        ("uniform", (4.0, 6.0), 5.0),
        ("triangular", (1.0, 2.0, 6.0), 3.0),
        ("normal", (8.0, 1.0), 8.0),
        ("lognormal", (5.0, 0.5), 5.0 * 2.718281828**0.125),
        ("exponential", (4.0,), 4.0),
    ],
)
def test_means_of_durations(kind, values, mean):
    from random import Random

    random = Random(1)
    draws = [Duration(kind, values).draw(random) for _ in range(4000)]
    assert sum(draws) / 4000 == pytest.approx(mean, rel=0.06)
    assert min(draws) >= 0.1


def test_a_custom_agent_rejects_shortens_and_hands_over_tasks(tmp_path):
    (tmp_path / "picky.asl").write_text("""\
+work_offered(_) : offer(Id, "dull", _, _, _) <- refuse(Id); !look_for_work.
+!hurry <- work_pace(2).
+human_start <- !hurry; !look_for_work.
choice(Id, S) :- offer(Id, "best", S, _, _).
{ include("worker.asl") }
""")
    (tmp_path / "shy.asl").write_text("""\
+human_start : offer(Id, "best", S, _, _) <- take(Id); .wait(1000); give_back.
""")
    run = sim.run(
        trial(
            """\
duration: 60
people:
  - {name: bob, personality: shy.asl, work: line}
  - {name: ann, personality: picky.asl, work: line}
work:
  line:
    - {name: dull, at: press, duration: 10, time: 2}
    - {name: usual, at: canteen, duration: 10}
    - {name: best, at: bench, duration: 10}
""",
            tmp_path,
        )
    )
    assert happened(run, "task_given_back") == [
        (1.0, "task_given_back", "bob", "best"),
        (2.0, "task_given_back", "ann", "dull"),
    ]
    assert [task for *_, task in happened(run, "task_taken")] == ["best", "usual", "best"]
    done = [e for e in run.events if e["kind"] == "task_done"]
    assert {e["task"]: round(e["took"], 6) for e in done} == {"usual": 5.0, "best": 5.0}


def test_interrupted_work_continues_where_it_stopped(tmp_path):
    (tmp_path / "restless.asl").write_text("""\
+human_start : offer(Id, _, S, _, _) <- take(Id); !walk_to(S); .wait(14000); stop_movement;
   .wait(5000); begin_task.
{ include("worker.asl") }
""")
    run = sim.run(
        trial(
            """\
duration: 60
people: [{name: ann, personality: restless.asl, work: line}]
work: {line: [{at: press, duration: 20}]}
""",
            tmp_path,
        )
    )
    paused, done = (
        next(e for e in run.events if e["kind"] == kind) for kind in ("task_paused", "task_done")
    )
    begun = next(e["t"] for e in run.events if e["kind"] == "task_begun")
    assert paused["left"] == pytest.approx(20 - (14 - begun))
    assert done["took"] == pytest.approx(25)
    assert run.summary["people"]["ann"]["time_working"] == pytest.approx(20)


def test_invalid_work_is_an_error():
    def found(text):
        with pytest.raises(sim.TrialError) as wrong:
            trial(text)
        return [f"{p.line}: {p.field}: {p.message}" for p in wrong.value.problems]

    assert found("""\
duration: 600
begins: "6"
people:
  - {name: ann, work: line, schedule: [at noon], shifts: [6 to 14], breaks: [09:00 bench for 1 hr]}
work:
  line: [{at: press}, {at: press, duration: 5, count: 2}]
""")[1:4] == [
        "8: people[0].schedule[0]: expected keys, or text as '09:00 station2 for 12 min', found"
        " 'at noon'",
        "8: people[0].breaks[0]: expected a length of time as 12 min, 90 s or 1.5 h, found '1 hr'",
        "8: people[0].shifts[0]: expected [begin, end] in seconds or '06:00 - 14:00', found"
        " '6 to 14'",
    ]
    assert found("""\
duration: 20 minutes
people: [{name: ann, work: line}]
work:
  line: [{at: press, duration: 5}]
""") == ["5: duration: expected a length of time as 12 min, 90 s or 1.5 h, found '20 minutes'"]
    assert found("""\
duration: 10 min
begins: 06:00
people:
  - name: ann
    shifts: [06:05 - 06:05, 07:00 - 08:00]
""")[:2] == [
        "9: people[0].shifts[0]: ends before it begins, or at once: 06:05 … 06:05",
        "9: people[0].shifts[1]: is at 3600 s (07:00) of the trial, which ends at 600 s",
    ]
    assert found("""\
duration: 600
begins: 06:00
people:
  - name: ann
    work: [lines]
    schedule: [06:01 bench for 5 min, 06:05 press for 1 min, 05:00 press for 1 min]
    breaks: [06:02 counter for 1 min]
    shifts: [[10, 5], [20, 30], [25, 40]]
work:
  line: [{at: pres, duration: 5, time: 700}]
""") == [
        "9: people[0].work[0]: no list of tasks is called 'lines'; did you mean 'line'?",
        "10: people[0].schedule[2].time: is at 82800 s (05:00) of the trial, which ends at 600 s",
        "10: people[0].schedule[1]: begins at 300 s, before schedule[0] ends at 360 s",
        "11: people[0].breaks[0].at: no station is called 'counter'; there are: press, bench,"
        " canteen",
        "11: people[0].breaks[0]: begins at 120 s, before schedule[0] ends at 360 s",
        "12: people[0].shifts[0]: ends before it begins, or at once: 10 s … 5 s",
        "12: people[0].shifts[2]: begins at 25 s, before the previous one ends",
        "14: work.line[0].at: no station is called 'pres'; did you mean 'press'?",
        "14: work.line[0].time: is at 700 s of the trial, which ends at 600 s",
        "14: work.line: no person takes tasks from this list; add it to the work of a person",
    ]


def test_times_of_day_are_written_as_seconds_and_shown_as_in_the_file(tmp_path):
    shift = trial("""\
duration: 20 min
begins: 05:50
people:
  - name: ann
    personality: worker
    work: line
    shifts: [06:00 - 06:08, [1100, 1100.5]]
    breaks: [06:04:30 canteen for 2 min]
work: {line: [{at: press, duration: 25, every: 1.5 min}]}
""")
    assert shift.duration == 1200 and shift.work["line"].tasks[0].every == 90
    assert shift.people[0].shifts == ((600.0, 1080.0), (1100.0, 1100.5))
    written = shift.to_yaml(tmp_path)
    assert "06:0" not in written
    assert sim.Trial.parse(written).people[0].shifts == shift.people[0].shifts
    sim.safety_report(sim.run(shift), tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert "shift 06:00 – 06:08; shift 1,100 s – 1,100.5 s; break at 06:04:30" in page


def test_work_made_in_python_is_written_and_read_again():
    plan = floorplan.load("warehouse")
    place = plan.stations[0].name
    made = sim.Trial(
        plan,
        floorplan_source="warehouse",
        people=(
            sim.PersonEntry(
                "ann",
                personality="worker",
                work=("line",),
                breaks=(WorkTask(place, Duration("fixed", (60.0,)), time=100.0),),
                shifts=((0.0, 200.0),),
            ),
        ),
        work={
            "line": WorkList(
                (
                    WorkTask(
                        place, Duration("exponential", (5.0,)), name="pick", every=9.0, count=3
                    ),
                    WorkTask(place, Duration("triangular", (1.0, 2.0, 4.0)), priority=-1),
                )
            )
        },
    )
    again = sim.Trial.parse(made.to_yaml(), file="trial.yaml")
    assert again.work == made.work
    assert again.people[0].shifts == made.people[0].shifts
    assert again.people[0].breaks[0].time == 100.0


def test_a_shorter_trial_omits_later_entries(floorwalker, tmp_path):
    """Its repeated moves also end with it."""
    text = """\
floorplan: warehouse
duration: 3600
agvs: {tug1: [{time: 10, to: east, every: 100}, {time: 60, to: west, every: 100}]}
work: {picks: [{at: aisle1, duration: 20, time: 5}, {at: aisle3, duration: 20, time: 900}]}
people: [{name: ann, personality: worker, work: picks, shifts: [[0, 500], [600, 900]]}]
"""
    (tmp_path / "day.trial.yaml").write_text(text)
    moves = sim.Trial.load(tmp_path / "day.trial.yaml").agvs["tug1"]
    assert len(moves) == 72 and [move.time for move in moves[:3]] == [10.0, 60.0, 110.0]
    words = ("run", "day.trial.yaml", "--duration", "120", "--out", "run", "--no-open")
    assert floorwalker(*words, cwd=tmp_path).returncode == 0
    run = sim.load_run(tmp_path / "run")
    assert run.duration == 120 and run.summary["tasks_done"] == 1


@pytest.mark.parametrize(
    ("kind", "values", "word"),
    [
        ("fixd", (5.0,), "fixed"),
        ("fixed", (), "1 values"),
        ("fixed", (0.0,), "from 0"),
        ("triangular", (3.0,), "3 values"),
        ("triangular", (9.0, 5.0, 3.0), "rise"),
        ("uniform", (5.0, 3.0), "rise"),
        ("normal", (-1.0, 3.0), "from 0"),
        ("lognormal", (0.0, 0.5), "from 0"),
        ("exponential", (float("nan"),), "from 0"),
    ],
)
def test_a_duration_that_cannot_be_drawn_is_a_fault_of_the_trial(kind, values, word):
    work = {"jobs": WorkList((WorkTask("press", Duration(kind, values)),), repeat=True)}
    floor = trial("").floorplan
    with pytest.raises(sim.TrialError, match=r"work.jobs.tasks\[0\].duration.*" + word):
        sim.run(sim.Trial(floor, work=work))


def test_an_unknown_name_on_a_floor_without_such_names_says_so():
    floor = trial("").floorplan
    with pytest.raises(sim.TrialError, match=r"'agv9'; there are: none"):
        sim.run(sim.Trial(floor, agvs={"agv9": ()}))
