"""Trials made in Python are checked by the rules of trial files."""

from dataclasses import replace
from pathlib import Path

import pytest
from run_events import said

import bdi
import floorplan
import sim

FLOOR = floorplan.load("ariac2023")
SHOP = floorplan.load("warehouse")
NAN = float("nan")


def ada(**keys):
    return {"people": (sim.PersonEntry("ada", **keys),)}


def rules(**keys):
    return {"rules": replace(sim.PAPER, **keys)}


def notice(**keys):
    return rules(notice=replace(sim.PAPER.notice, **keys))


def jobs(*entries):
    return {"gantry": sim.GantryEntry("oblivious", jobs=entries)}


def moves(*entries, agv="agv1"):
    return {"agvs": {agv: tuple(sim.AgvMove(time, to) for time, to in entries)}}


def changes(personality, time=5.0):
    return ada(changes=(sim.PersonalityChange(sim.Start(time), personality),))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"duration": -1.0}, "duration: must be more than 0 and at most 1e.10, not -1.0"),
        ({"duration": 1e10}, "duration: must be"),
        ({"seed": 1 << 20_000}, "seed: must be a whole number from 0 to .*, not a larger one"),
        (rules(grace=-1.0), r"rules.grace: must be a time from 0 to 1e.10 s, not -1.0"),
        (notice(every=0.0), "rules.notice.every: must be more than 0"),
        (notice(parting=-1.0), "rules.notice.parting: must be more than 0, not -1.0"),
        (ada(at=(100.0, 1.0)), r"people\[0\].at: \(100, 1\) is outside the boundary"),
        (ada(at=(-7.3, 3.0)), r"people\[0\].at: .*inside obstacle 'assembly_table1'"),
        (ada(at=(-2.0, 4.9)), r"people\[0\].at: \(-2, 4.9\) is inside agv1, which stands there"),
        (ada(home=(-2.0, 4.9)), r"people\[0\].home: \(-2, 4.9\) is inside agv1"),
        (ada(radius=1.5, at=(-19.0, 0.0)), r"people\[0\]: in the safe zone, .* give home"),
        (ada(radius=-0.1), r"people\[0\].radius: must be more than 0"),
        (ada(radius=5.0), r"people\[0\]: in the safe zone, .* does not fit"),
        (ada(max_acceleration=NAN), r"people\[0\].max_acceleration: must be more than 0"),
        (ada(personality="hepful"), r"people\[0\].personality: .*did you mean 'helpful'"),
        (ada(beliefs=("tired", "tall(")), r"people\[0\].beliefs\[1\]: is not a belief"),
        (ada(start=sim.Start(NAN)), r"people\[0\].start.time: must be a time .* not nan"),
        (ada(start=sim.Start(None)), r"people\[0\].start: must be one of time, part_placed"),
        (ada(start=sim.Start(5.0, event="notice")), r"people\[0\].start: must be one of"),
        (ada(start=sim.Start(event="notiec")), r"start.event: .*did you mean 'notice'"),
        (ada(start=sim.Start(event="notice", count=0)), r"start.count: must be 1 or more"),
        (ada(start=sim.Start(order_submitted="K1")), r"start.order_submitted: no order is called"),
        (ada(start=sim.Start(part_placed={"agv": "agv7"})), "part_placed.agv: no agv is called"),
        (ada(start=sim.Start(part_placed={"part": "x"})), "part_placed.part: no part is called"),
        (ada(start=sim.Start(part_placed={"prat": "x"})), "prat: unknown key; did you mean 'part'"),
        (changes("hepful"), r"changes\[0\].personality: .*did you mean 'helpful'"),
        (changes("external"), r"people\[0\].changes: no personality changes to or from 'external'"),
        (changes("helpful", -3.0), r"changes\[0\].when.time: must be a time"),
        ({"people": (sim.PersonEntry("ada"),) * 2}, r"people\[1\].name: another body"),
        ({"people": (sim.PersonEntry("agv2"),)}, r"people\[0\].name: another body"),
        ({"people": (sim.PersonEntry(""),)}, r"people\[0\].name: must begin with a letter"),
        ({"gantry": sim.GantryEntry(at=(9.0, 0.0, 0.0))}, "gantry.at: x = 9 is outside"),
        (jobs(sim.Job("dance")), r"gantry.jobs\[0\]: a job is one of .* not 'dance'"),
        (jobs(sim.Job("wait", seconds=-1.0)), r"gantry.jobs\[0\].wait: must be more than 0"),
        (jobs(sim.Job("move", target=(9.0, 0.0, 0.0))), r"jobs\[0\].move: x = 9 is outside"),
        (jobs(sim.Job("pick_place", pick="bin1", place="bni2")), r"jobs\[0\].place: .*'bni2'"),
        ({"until_submitted": True}, "until_submitted: no order is submitted"),
        (moves((1.0, "as1"), agv="agv7"), "agvs.agv7: no AGV is called 'agv7'"),
        (moves((1.0, "as9")), r"agvs.agv1\[0\].to: agv1 has no location 'as9'"),
        (moves((1.0, 500.0)), r"agvs.agv1\[0\].to: agv1 can't be at 500 m"),
        (moves((NAN, "as1")), r"agvs.agv1\[0\].time: must be a time"),
        (moves((5.0, "as1"), (1.0, "kitting")), r"agvs.agv1\[1\].time: 1 s is before"),
        ({"expect": {"penaltes": 0}}, "expect.penaltes: .*the nearest are penalties"),
        ({"floorplan": SHOP, **jobs()}, "gantry: the floorplan has no gantry"),
        (
            {"floorplan": replace(FLOOR, safe_zone=None), **ada()},
            r"people\[0\]: the floorplan has no safe zone to start in",
        ),
    ],
)
def test_an_impossible_trial_is_reported_before_the_run(keys, message):
    trial = sim.Trial(**{"floorplan": FLOOR, "name": "mine", "duration": 10.0, **keys})
    with pytest.raises(sim.TrialError, match=message) as error:
        sim.Simulation(trial)
    assert str(error.value).startswith("trial 'mine': ")
    assert len(error.value.problems) == 1


def test_all_problems_are_reported_at_once():
    trial = sim.Trial(FLOOR, duration=-1.0, **ada(at=(99.0, 0.0)), expect={"nothing": 1})
    with pytest.raises(sim.TrialError, match="3 problems"):
        sim.run(trial)


def test_a_program_can_be_a_personality():
    program = bdi.parse("!rest. +!rest <- .print(resting).", "calm")
    change = sim.PersonalityChange(sim.Start(0.5), bdi.parse("!go. +!go <- .print(going).", "busy"))
    person = sim.PersonEntry("ada", personality=program, changes=(change,))
    trial = sim.Trial(FLOOR, duration=1.0, people=(person,))
    assert said(sim.run(trial)) == ["resting", "going"]
    assert sim.run(trial).summary["people"]["ada"]["personality"] == "calm"
    assert said(sim.run(trial.with_personality(program))) == ["resting"]


def test_only_the_personality_decides_the_behaviour_of_a_person(tmp_path):
    for mood in ("calm", "busy"):
        (tmp_path / f"{mood}.asl").write_text(f"!go. +!go <- .print({mood}).")
    text = "floorplan: ariac2023\nduration: 1\npeople: [{name: ada, personality: calm.asl}]\n"
    trial = sim.Trial.parse(text, folder=tmp_path)
    other = replace(trial, people=(replace(trial.people[0], personality="busy.asl"),))
    assert (said(sim.run(trial)), said(sim.run(other))) == (["calm"], ["busy"])
    # The file is read again for each run.
    (tmp_path / "calm.asl").write_text("!go. +!go <- .print(excited).")
    assert said(sim.run(trial)) == ["excited"]


def test_an_unknown_personality_is_the_same_error_everywhere():
    def changes_to(name):
        simulation = sim.Simulation(sim.Trial(FLOOR, **ada()))
        simulation.people[0].change_personality(name)

    unknown = (
        lambda name: sim.run(sim.Trial(FLOOR, **ada(personality=name))),
        lambda name: sim.Trial(FLOOR, **ada()).with_personality(name),
        lambda name: sim.Trial.parse(
            f"floorplan: ariac2023\npeople: [{{name: ada, personality: {name}}}]"
        ),
        changes_to,
    )
    for use in unknown:
        with pytest.raises(sim.TrialError, match="'hepful'; did you mean 'helpful'"):
            use("hepful")


def test_a_person_who_waits_for_an_event_does_not_start_at_once():
    start = sim.Start(event="job_done")
    assert start == sim.Start(None, event="job_done")
    trial = sim.Trial(FLOOR, duration=10.0, **ada(start=start), **jobs(sim.Job("wait", seconds=4)))
    run = sim.run(trial)
    assert [e["t"] for e in run.events if e["kind"] == "human_started"] == [4.0]
    assert sim.Trial.parse(trial.to_yaml()) == replace(trial, folder=Path())


@pytest.mark.parametrize("by", ["reading", "running"])
def test_a_dictionary_changed_after_a_check_is_checked_again(by):
    trial = sim.Trial.parse("floorplan: ariac2023\nduration: 0.5\npeople: []")
    if by == "running":
        trial = sim.Trial(trial.floorplan, duration=0.5)
        sim.run(trial)
    trial.expect["no_such_figure"] = "< 1"
    with pytest.raises(sim.TrialError, match=r"expect\.no_such_figure"):
        sim.run(trial)


def test_a_machine_changed_after_reading_is_checked_again():
    trial = sim.Trial.load("ariac2023")
    trial.agvs["agv9"] = ()
    with pytest.raises(sim.TrialError, match=r"agvs\.agv9"):
        sim.run(trial)
