"""Reaction times of people: by the rules, by the trial, and by the lag of their agents."""

from dataclasses import replace

import pytest
from run_events import events

import sim

SCENE = """
floorplan: ariac2023
duration: 100
rules: {rules}
people: [{{name: operator, personality: {personality}{more}}}]
gantry: {{controller: parked, at: [-2.5, 0.5, 0.0]}}
"""


def scene(personality, rules="ariac2023", more=""):
    trial = sim.Trial.parse(SCENE.format(rules=rules, personality=personality, more=more))
    return sim.run(trial)


def wait(run):
    """Return the time between the first notice of the gantry and the next goal (s)."""
    noticed = events(run, "gantry_detected")[0]["t"]
    return next(one["t"] for one in events(run, "goal") if one["t"] >= noticed) - noticed


@pytest.mark.parametrize(
    ("personality", "rules", "seconds"),
    [
        ("helpful", "ariac2023", 1.5),
        ("antagonistic", "ariac2023", 2.5),
        ("helpful", "paper", 1.0),
        ("antagonistic", "paper", 0.0),
        ("helpful", "{based_on: ariac2023, reactions: {helpful: 0.5}}", 0.5),
        ("antagonistic", "{based_on: ariac2023, reactions: {helpful: 0.5}}", 2.5),
        ("antagonistic", "{reactions: {antagonistic: 0.25}}", 0.25),
    ],
)
def test_rule_sets_state_how_long_people_wait_before_they_react(personality, rules, seconds):
    assert wait(scene(personality, rules)) == pytest.approx(seconds, abs=1e-9)


@pytest.mark.parametrize("personality", ["helpful", "antagonistic"])
def test_a_belief_about_the_reaction_precedes_the_rules(personality):
    run = scene(personality, more=', beliefs: ["consideration(300)"]')
    assert wait(run) == pytest.approx(0.3, abs=1e-9)


def test_a_waiting_person_is_stationary():
    run = scene("antagonistic")
    noticed = events(run, "gantry_detected")[0]["t"]
    at = run.motions["operator"].state
    # A person at 1.0 m/s needs 0.4 s to stop at 2.5 m/s².
    stopped = pytest.approx(at(noticed + 0.4).at, abs=1e-6)
    assert at(noticed + 2.5).at == stopped
    assert at(noticed + 3.0).at != stopped


def test_reactions_are_written_and_read_again():
    rules = replace(sim.RULE_SETS["ariac2023"], name="slow", reactions={"helpful": 3.0})
    trial = replace(sim.Trial.load("scene_helpful"), rules=rules)
    assert sim.Trial.parse(trial.to_yaml()).rules == rules


@pytest.mark.parametrize("seconds", ["-1", ".nan", "soon"])
def test_a_reaction_is_a_time(seconds):
    with pytest.raises(sim.TrialError, match=r"reactions\.helpful"):
        scene("helpful", f"{{reactions: {{helpful: {seconds}}}}}")
    if seconds != "soon":
        rules = replace(sim.PAPER, reactions={"helpful": float(seconds.strip("."))})
        with pytest.raises(sim.TrialError, match=r"reactions\.helpful"):
            sim.run(replace(sim.Trial.load("scene_helpful"), rules=rules))


# ---- the agent's lag


def lags(run):
    """Return the time from each arrival to the next goal (s)."""
    goals = [one["t"] for one in events(run, "goal")]
    arrivals = [one["t"] for one in events(run, "arrived")]
    return [min(t for t in goals if t >= then) - then for then in arrivals if then < goals[-1]]


def test_an_agent_lags_behind_what_happens():
    assert set(lags(scene("indifferent"))) == {0.0}
    run = scene("indifferent", more=", agent_lag: 0.75")
    assert lags(run) == pytest.approx([0.75] * len(lags(run)), abs=1e-9)


def test_a_lag_is_drawn_for_each_thought_from_the_seed_and_the_name():
    one = scene("indifferent", "observe", ", agent_lag: [0, 1.05]")
    drawn = lags(one)
    assert len({round(lag, 6) for lag in drawn}) == len(drawn) > 5
    assert all(0 <= lag <= 1.05 for lag in drawn)
    assert lags(scene("indifferent", "observe", ", agent_lag: [0, 1.05]")) == drawn
    trial = sim.Trial.parse(
        SCENE.format(rules="observe", personality="indifferent", more=", agent_lag: [0, 1.05]")
    )
    assert lags(sim.run(replace(trial, seed=1))) != drawn


def test_an_agent_that_lags_is_sent_home_once_and_walks_until_then():
    run = scene("indifferent", more=", agent_lag: 0.75")
    violation, teleport, *_ = sorted(
        [*events(run, "violation"), *events(run, "teleport")], key=lambda one: one["t"]
    )
    assert (violation["kind"], teleport["kind"]) == ("violation", "teleport")
    assert teleport["t"] - violation["t"] == pytest.approx(0.75, abs=1e-9)
    counts = run.summary["violations"], len(events(run, "teleport"))
    assert len(events(run, "teleport")) <= len(events(run, "violation")), counts
    walked = run.motions["operator"]
    assert walked.state(violation["t"] + 0.5).speed > 0


def test_a_program_without_a_reaction_is_sent_home_when_its_agent_has_thought(tmp_path):
    (tmp_path / "deaf.asl").write_text("+human_start <- move(-3, 0, 0).")
    run = scene(tmp_path / "deaf.asl", more=", agent_lag: 0.75")
    violation, teleport = events(run, "violation")[0], events(run, "teleport")[0]
    assert teleport["t"] - violation["t"] == pytest.approx(0.75, abs=1e-9)


def test_a_wait_of_the_program_ends_without_a_lag(tmp_path):
    (tmp_path / "waits.asl").write_text("+human_start <- .wait(2000); .print(now).")
    run = scene(tmp_path / "waits.asl", more=", agent_lag: 0.75")
    assert [one["t"] for one in events(run, "said")] == [2.0]


def test_a_lag_is_written_and_read_again():
    person = sim.PersonEntry("ada", agent_lag=(0.0, 1.05))
    trial = replace(sim.Trial.load("scene_helpful"), people=(person,), expect={})
    assert sim.Trial.parse(trial.to_yaml()).people == (person,)


@pytest.mark.parametrize(
    ("lag", "message"),
    [
        ("agent_lag: -1", "agent_lag"),
        ("agent_lag: [2, 1]", "agent_lag"),
        ("agent_lag: 1, personality: external", "agent_lag: .*no agent; omit it"),
    ],
)
def test_an_invalid_lag_is_rejected(lag, message):
    text = f"floorplan: ariac2023\npeople: [{{name: a, {lag}}}]\n"
    with pytest.raises(sim.TrialError, match=message):
        sim.Trial.parse(text)
