"""The cell at work that comes with Floorwalker, and that newcomers run first."""

import sim


def test_it_meets_what_it_expects():
    assert sim.run(sim.Trial.load("workcell")).unmet == []
