"""The controller in polite.py, beside people of several minds."""

import pytest

pytestmark = pytest.mark.controllers("polite:polite")


@pytest.mark.personalities("helpful")
@pytest.mark.seeds(range(2))
def test_who_looks_out_is_in_no_danger(run_trial):
    assert run_trial().summary["penalties"] == 0


@pytest.mark.personalities("all")
@pytest.mark.rule_sets("paper")
def test_work_gets_done_whoever_walks_about(run_trial):
    assert run_trial().summary["jobs_done"] >= 2
