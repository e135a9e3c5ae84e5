"""People among moving vehicles in open halls: contacts only where no place can be reached."""

import os

import pytest

import sim

from . import random_trial_of_vehicles, vehicle_faults
from .open_halls import faults_in_hall


@pytest.mark.parametrize("first", range(0, 20, 5))
def test_every_contact_with_a_vehicle_was_unavoidable(first):
    by_hall = [faults_in_hall(number)[0] for number in range(first, first + 5)]
    assert [fault for wrong in by_hall for fault in wrong] == []


def test_a_person_leaves_by_a_walk_between_the_discs_and_the_vehicle():
    assert faults_in_hall(238)[0] == []


def test_a_person_in_a_slow_zone_leaves_by_a_walk_among_the_discs_of_a_vehicle():
    assert [*vehicle_faults(sim.run(random_trial_of_vehicles(33)))] == []


HALLS = 1000 if os.environ.get("HYPOTHESIS_PROFILE") == "explore" else 200


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, HALLS, 50))
def test_every_contact_with_a_vehicle_was_unavoidable_in_many_halls(first):
    by_hall = [faults_in_hall(number)[0] for number in range(first, first + 50)]
    assert [fault for wrong in by_hall for fault in wrong] == []
