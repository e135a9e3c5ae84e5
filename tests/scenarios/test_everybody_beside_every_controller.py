"""Each personality beside each gantry controller, in every combination."""

import numpy as np
import pytest

import sim

CAUTIOUS = ("pausing", "avoiding")


@pytest.fixture(scope="module")
def ariac_cell():
    """A shorter shift, in which all combinations fit."""
    return sim.Trial.parse(
        """
floorplan: ariac2023
duration: 60
people: [{name: operator}]
gantry:
  controller: oblivious
  at: [-4.0, 1.0, 0.0]
  repeat: true
  jobs: [{pick: bin2, place: agv1}, {pick: bin6, place: agv4}]
expect:
  timeline:
    - {whenever: violation, then: teleport, within: 0.001}
    - {whenever: {kind: violation, penalty: true}, then: gantry_disabled, within: 0.001}
    - {whenever: teleport, then: {kind: goal, station: station4}, within: 10.1}
    - {eventually: {kind: arrived, station: station4}}
"""
    )


@pytest.mark.personalities("all")
@pytest.mark.controllers("all")
def test_the_referee_is_right_and_has_its_consequences(run_trial):
    run = run_trial()
    assert run.unmet == []
    violations = [e for e in run.events if e["kind"] == "violation"]
    assert run.summary["penalties"] == sum(e["penalty"] for e in violations)
    assert sum(run.summary["violations"].values()) == run.summary["penalties"]
    if run.trial.gantry.controller in CAUTIOUS:
        assert run.summary["violations"]["gantry"] == 0
    # Sampled motions show short distances only where the referee records violations.
    samples = run.sample(rate=100.0)
    person, gantry = samples["operator"], samples["gantry"]
    apart = np.hypot(*(person[:, :2] - gantry[:, :2]).T)
    human, robot = np.hypot(*person[:, 3:].T), np.hypot(*gantry[:, 3:].T)
    law = run.trial.rules.gantry_law
    required = np.array([law.distance(h, r) for h, r in zip(human, robot, strict=True)])
    too_close = samples["t"][apart < required - 1e-9]
    intervals = run.violations["operator", "gantry"]
    assert all(any(b - 0.02 <= t <= e + 0.02 for b, e in intervals) for t in too_close)


@pytest.mark.personalities("all")
@pytest.mark.controllers(*CAUTIOUS)
@pytest.mark.rule_sets("ariac2023")
def test_a_cautious_gantry_causes_no_violation_under_other_rules(run_trial):
    assert run_trial().summary["violations"]["gantry"] == 0
