"""The built-in cell at work, which newcomers run first."""

import sim


def test_the_workcell_meets_its_expectations():
    assert sim.run(sim.Trial.load("workcell")).unmet == []
