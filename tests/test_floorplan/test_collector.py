"""Garbage collection during runs: exempt objects, and the state afterwards."""

import gc

import pytest

import sim
from floorplan.files.collector import frozen_collector


@pytest.fixture(autouse=True)
def unfrozen(monkeypatch):
    """Release the objects that the test suite has frozen, and freeze them again afterwards."""
    monkeypatch.setattr("floorplan.files.collector._is_frozen", False)
    gc.unfreeze()
    yield
    gc.freeze()


class Count(sim.Listener):
    """Records whether objects are frozen at each event."""

    def __init__(self):
        self.frozen = []

    def event(self, event):
        self.frozen.append(gc.get_freeze_count() > 0)


def collector():
    return gc.isenabled(), gc.get_threshold(), gc.get_freeze_count() > 0


def test_objects_are_frozen_during_a_run_and_released_after_it():
    before, count = collector(), Count()
    sim.run(sim.Trial.parse("floorplan: ariac2023\nduration: 1\n"), count)
    assert count.frozen
    assert all(count.frozen)
    assert collector() == before == (True, gc.get_threshold(), False)


def test_an_error_restores_the_collector():
    before = collector()
    with pytest.raises(RuntimeError), frozen_collector():
        raise RuntimeError
    assert collector() == before


def test_frozen_objects_of_the_program_stay_frozen():
    gc.freeze()
    before = collector()
    with frozen_collector():
        assert gc.get_threshold() == before[1]
    assert collector() == before
    assert before[2]


def test_a_disabled_collector_stays_disabled():
    gc.disable()
    try:
        before = collector()
        with frozen_collector():
            assert collector() == before
        assert collector() == before
    finally:
        gc.enable()


def test_a_run_inside_another_does_not_release_its_objects():
    with frozen_collector():
        with frozen_collector():
            pass
        assert collector()[2]
