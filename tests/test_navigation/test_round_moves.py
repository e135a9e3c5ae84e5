"""Moves over whole millimetres within round limits, at which two profiles tie."""

import math
import random

import pytest

import navigation
from navigation import VehicleLimits
from navigation.machines import AxisLimits, gantry_move
from navigation.motion import State

SPEEDS = (0.1, 0.2, 0.25, 0.3, 0.5, 0.6, 0.75, 0.8, 1.0, 1.2, 1.5, 1.8, 2.0)
ACCELERATIONS = (0.1, 0.2, 0.25, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8, 0.9, 1.0, 1.2, 1.5, 2.5, 10.0)
JERKS = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 4.5, 5.0, 6.0, 10.0, 20.0, 100.0, 2000.0, math.inf)


def duration(length, limits):
    """Return the duration of the fastest move between rests (Biagiotti and Melchiorri)."""
    v, a, j = limits.max_speed, limits.max_acceleration, limits.max_jerk
    if j == math.inf:
        return length / v + v / a if length >= v * v / a else 2 * math.sqrt(length / a)
    rise = a / j if v * j >= a * a else math.sqrt(v / j)
    a = j * rise
    if length >= v * (v / a + rise):
        return length / v + v / a + rise
    if length >= 2 * a**3 / j**2:
        peak = (-a * rise + math.sqrt((a * rise) ** 2 + 4 * a * length)) / 2
        return 2 * (peak / a + rise)
    return 4 * (length / (2 * j)) ** (1 / 3)


def tied_length(draw, axis):
    """Return a length at which an axis just reaches its limits, or any length."""
    v, a, j = axis.max_speed, axis.max_acceleration, axis.max_jerk
    jerk = min(j, 1e6)
    tie = draw.choice([2 * a**3 / jerk**2, v * v / a + v * a / jerk, 2 * v * math.sqrt(v / jerk)])
    length = draw.choice([tie, round(tie, 3), draw.randint(1, 3000) / 1000])
    return length if 1e-6 < length < 100.0 else 0.032


def limits_of(draw):
    return AxisLimits(draw.choice(SPEEDS), draw.choice(ACCELERATIONS), draw.choice(JERKS))


def check_moves(count, seed):
    draw = random.Random(seed)
    for _ in range(count):
        axes = tuple(limits_of(draw) for _ in range(3))
        begin = [draw.choice([0.0, draw.randint(-9000, 9000) / 1000]) for _ in axes]
        spans = [draw.choice([0, 1, 1, -1]) * tied_length(draw, axis) for axis in axes]
        end = tuple(a + b for a, b in zip(begin, spans, strict=True))
        speeds = [draw.choice([0.0, 0.5, 1.0, -0.5]) * axis.max_speed for axis in axes]
        moving = draw.random() < 0.4
        start = State(tuple(begin), tuple(speeds), (0.0, 0.0, 0.0)) if moving else tuple(begin)
        motion = gantry_move(start, end, 2.0, limits=axes)
        there = motion.state(motion.end).position
        # Ruckig ends within 1e-8 m if it slows axes down to arrive together.
        assert math.dist(there, end) < (2e-8 if moving else 1e-9), (axes, start, end)

        (axis, *_), length = axes, tied_length(draw, axes[0])
        limits = VehicleLimits(
            speed=axis.max_speed, acceleration=axis.max_acceleration, jerk=axis.max_jerk
        )
        x = begin[0]
        drive = navigation.vehicle_segment((x, 0.0, 0.0), (x + length, 0.0), limits=limits)
        assert drive.position(drive.end)[0] == pytest.approx(x + length, abs=1e-9)
        if axis.max_jerk <= 1e3 * axis.max_acceleration:
            assert drive.end == pytest.approx(duration(length, axis), rel=1e-6), (axis, length)


def test_moves_over_whole_millimetres_within_round_limits_exist():
    check_moves(2000, seed=1)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 12))
def test_many_moves_within_round_limits_exist(seed):
    check_moves(10_000, seed)


@pytest.mark.parametrize(
    ("limits", "length"),
    [((0.8, 0.4, 2.0), 0.032), ((0.3, 0.2, 1.0), 0.016), ((1.0, 10.0, 100.0), 0.2)],
)
def test_a_move_at_a_tie_is_the_fastest_from_any_start(limits, length):
    axis = AxisLimits(*limits)
    draw = random.Random(5)
    for _ in range(300):
        x = draw.uniform(-9.0, 9.0)
        move = gantry_move((x, 0.0, 0.0), (x + length, 0.0, 0.0), limits=(axis, axis, axis))
        assert move.end == pytest.approx(duration(length, axis), rel=1e-9)
        assert move.position(move.end)[0] == pytest.approx(x + length, abs=1e-12)
