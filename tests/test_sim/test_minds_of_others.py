"""Agents among people: percepts of other people, and actions for them."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from run_events import events, record

import floorplan
import navigation
import sim

FLOOR = """
name: hall
boundary: [[0, 0], [24, 0], [24, 8], [0, 8]]
stations: {west: [2, 4], east: [22, 4]}
safe_zone: {at: [2, 2]}
"""


@pytest.fixture
def meet(tmp_path):
    """Return a function that runs people in a hall, each with a program and a start."""

    def run(duration: float = 30.0, **people: tuple[str, tuple[float, float]]) -> sim.Run:
        entries = []
        for name, (program, at) in people.items():
            (tmp_path / f"{name}.asl").write_text(program)
            entries.append(sim.PersonEntry(name=name, personality=f"{name}.asl", at=at))
        plan = sim.Trial.parse(f"floorplan: {{{_inline(FLOOR)}}}").floorplan
        trial = sim.Trial(floorplan=plan, people=tuple(entries), duration=duration, folder=tmp_path)
        return sim.run(trial)

    return run


def _inline(floor: str) -> str:
    return ", ".join(floor.strip().splitlines())


def apart(run: sim.Run, a: str, b: str, t: float) -> float:
    return math.dist(run.motions[a].state(t).at, run.motions[b].state(t).at)


def said(run: sim.Run, person: str) -> list[tuple[str, float]]:
    return [(e["text"], e["t"]) for e in events(run, "said") if e["person"] == person]


WALK = "+human_start <- move(22, 4, 0)."
STAND = "+human_start."
LOOK = """
+human_start.
+person_near(Who, N) <- .print("near ", Who, " ", N).
+person_gone(Who, N) <- .print("gone ", Who, " ", N).
"""


def test_a_passing_person_is_perceived_as_near_and_as_gone(meet):
    """The percepts come at the exact times at which the centres are 3.6 m and then 4.1 m apart."""
    run = meet(ada=(LOOK, (12, 6.5)), ben=(WALK, (2, 4)))
    (near, came), (gone, went) = said(run, "ada")
    assert (near, gone) == ("near ben 0", "gone ben 0") and came < went
    assert apart(run, "ada", "ben", came) == pytest.approx(3.6, abs=1e-6)
    assert apart(run, "ada", "ben", went) == pytest.approx(4.1, abs=1e-6)
    closer = navigation.when(
        navigation.TooClose(navigation.FixedDistance(3.6)),
        run.motions["ada"],
        run.motions["ben"],
        0,
        30,
    )
    assert next(iter(closer))[0] == pytest.approx(came, abs=1e-6)


def test_people_who_meet_perceive_each_other(meet):
    report = '+{0}(Who, _) <- .print("{0} ", Who).'
    program = (
        WALK
        + "\n"
        + "\n".join(
            report.format(percept) for percept in ("in_the_way", "gives_way", "wants_to_pass")
        )
    )
    back = program.replace("22, 4", "2, 4")
    run = meet(ada=(program, (2, 4)), ben=(back, (22, 4)))
    seen = {text for name in ("ada", "ben") for text, _ in said(run, name)}
    assert seen & {"in_the_way ada", "in_the_way ben"}
    assert len(events(run, "met")) == sum("in_the_way" in text for text in seen)


def test_letting_a_person_pass_is_a_stop_until_they_have_passed(meet):
    """The paths cross at a right angle. Without the stop, both would be there at the same time."""
    lets = "+human_start <- move(12, 7.5, 0); .wait(500); let_pass(ben)."
    run = meet(ada=(lets, (12, 0.5)), ben=(WALK.replace("22", "20"), (4, 4)))
    stands = next(t for t in np.arange(0.6, 20, 0.01) if run.motions["ada"].state(t).speed == 0)
    goes = next(t for t in np.arange(stands, 30, 0.01) if run.motions["ada"].state(t).speed > 0)
    assert goes - stands > 3 and run.motions["ben"].state(goes).at[0] == pytest.approx(12, abs=0.1)
    assert run.motions["ada"].state(30).at == pytest.approx((12, 7.5))
    (arrival,) = (e for e in events(run, "arrived") if e["person"] == "ada")
    assert arrival["at"] == [12, 7.5]


def test_a_person_continues_after_the_patience_if_the_other_does_not_pass(meet):
    lets = "+human_start <- move(12, 7.5, 0); .wait(500); let_pass(ben)."
    run = meet(ada=(lets, (12, 0.5)), ben=(STAND, (4, 4)))
    assert any(e["person"] == "ada" for e in events(run, "arrived"))


def test_a_follower_stays_behind_until_its_next_action(meet):
    follows = "+human_start <- follow(ben); .wait(14000); stop_movement."
    run = meet(ada=(follows, (3, 4)), ben=(WALK, (6, 4)))
    for t in np.arange(6.0, 13.0, 0.5):
        assert 1.0 < apart(run, "ada", "ben", t) < 4.0
        assert run.motions["ada"].state(t).at[0] < run.motions["ben"].state(t).at[0]
    assert run.motions["ada"].state(15.5).speed == 0
    assert not [e for e in events(run, "arrived") if e["person"] == "ada"]


def test_people_who_walk_together_are_side_by_side(meet):
    run = meet(
        ada=("+human_start <- walk_with(ben).", (6, 3)),
        ben=("+human_start <- walk_speed(0.8); move(22, 4, 0).", (6, 4)),
    )
    for t in np.arange(3.0, 18.0, 0.5):
        (ax, ay), (bx, by) = (run.motions[name].state(t).at for name in ("ada", "ben"))
        assert abs(ax - bx) < 1.0 and 0.6 < by - ay < 1.3


def test_approaching_ends_in_front_of_a_person_who_has_stopped(meet):
    run = meet(
        ada=("+human_start <- approach(ben). +work_completed(_) <- .print(there).", (2, 1)),
        ben=("+human_start <- move(16, 6, 0).", (10, 4)),
    )
    ((_, when),) = said(run, "ada")
    assert run.motions["ben"].state(when).at == pytest.approx((16, 6))
    assert 0.6 < apart(run, "ada", "ben", when) < 1.8


def test_avoiding_a_person_is_walking_away_from_them(meet):
    run = meet(ada=("+human_start <- avoid(ben).", (8, 4)), ben=(STAND, (6, 4)))
    assert run.motions["ada"].state(30).at == pytest.approx((11, 4))


def test_an_unknown_name_is_an_error_with_the_known_names(meet):
    with pytest.raises(
        floorplan.UserError, match=r"ada: the action follow\(bne\): no other person .* 'ben'"
    ):
        meet(ada=("+human_start <- follow(bne).", (8, 4)), ben=(STAND, (6, 4)))
    with pytest.raises(floorplan.UserError, match=r"follow\(1\) should be follow\(who\)"):
        meet(ada=("+human_start <- follow(1).", (8, 4)), ben=(STAND, (6, 4)))


def test_waits_for_names_the_person_who_causes_the_wait(meet):
    asks = "+human_start <- move(22, 4, 0); .wait(8000); ?waits_for(Who); .print(Who)."
    run = meet(ada=(asks, (2, 4)), **{f"b{k}": (STAND, (12, 0.31 + 0.61 * k)) for k in range(13)})
    assert run.summary["overlaps"] == 0
    waiting = said(run, "ada")
    assert not waiting or waiting[0][0].startswith("b")


@pytest.mark.parametrize("count", [2, 5])
def test_a_group_walks_together(count):
    crew = f"{{name: g, count: {count}, group: crew, at: anywhere}}"
    text = f"floorplan: {{{_inline(FLOOR)}}}\nduration: 40\npeople: [{crew}]"
    trial = sim.Trial.parse(text)
    assert sim.Trial.parse(trial.to_yaml()) == trial
    run = sim.run(trial)
    names = list(run.summary["people"])
    assert run.summary["overlaps"] == 0 and run.summary["people"]["g1"]["visits"]
    assert all(run.summary["people"][name]["visits"] == [] for name in names[1:])
    for t in np.arange(8.0, 40.0, 1.0):
        assert max(apart(run, "g1", name, t) for name in names[1:]) < 5.0
    walked = [run.summary["people"][name]["distance_walked"] for name in names]
    assert min(walked) > 0.75 * walked[0]


@pytest.mark.parametrize("personality", ["helpful", "scared", "curious"])
def test_people_with_custom_manners_pass_a_corner(personality):
    trial = sim.Trial.load("people_corner").with_personality(personality)
    run = sim.run(dataclasses.replace(trial, duration=90.0))
    assert run.summary["overlaps"] == run.summary["deadlocks"] == 0
    assert all(figures["visits"] for figures in run.summary["people"].values())
    usual = sim.run(dataclasses.replace(sim.Trial.load("people_corner"), duration=90.0))
    assert run.events[:50] != usual.events[:50]


def test_a_rule_sets_the_minimum_distance_between_people(tmp_path):
    """The times and their sum match the motions."""
    trial = sim.Trial.load("people_frontal")
    rules = dataclasses.replace(trial.rules, name="ours", between_people=0.5)
    ours = dataclasses.replace(trial, rules=rules, expect={"people_too_near": ">= 1"})
    assert sim.Trial.parse(ours.to_yaml(), folder=".").rules == rules
    run = record(ours, tmp_path / "run")
    near = navigation.TooClose(navigation.FixedDistance(1.1))
    intervals = list(navigation.when(near, run.motions["ada"], run.motions["ben"], 0, run.duration))
    recorded = events(run, "people_too_near")
    assert [e["t"] for e in recorded] == pytest.approx([begin for begin, _ in intervals], abs=1e-6)
    assert all(e["distance"] == pytest.approx(0.5, abs=1e-6) for e in recorded)
    time = sum(end - begin for begin, end in intervals)
    assert run.summary["people_too_near_time"] == pytest.approx(time, abs=0.05)
    assert run.unmet == [] and sim.load_run(tmp_path / "run").scene.rules == rules
    assert "people_too_near" not in sim.run(trial).summary
    begin, end = intervals[0]
    middle = (begin + end) / 2
    ended = sim.run(dataclasses.replace(ours, duration=middle, expect={}))
    assert ended.summary["people_too_near_time"] == pytest.approx(middle - begin, abs=1e-3)


@pytest.mark.parametrize(("apart", "near"), [(1.05, True), (1.15, False)])
def test_the_distance_between_people_is_that_of_their_bodies(apart, near):
    trial = sim.Trial.parse(
        f"""
floorplan: {{{_inline(FLOOR)}}}
duration: 0.01
rules: {{between_people: 0.5}}
people: [{{name: wide, radius: 0.4, at: [3, 3]}}, {{name: slim, radius: 0.2, at: [{3 + apart}, 3]}}]
"""
    )
    recorded = events(sim.run(trial), "people_too_near")
    assert [e["distance"] for e in recorded] == ([pytest.approx(apart - 0.6)] if near else [])
