"""Social work: how much bodies would push people away, in the social force model.

The force is that of M. Moussaïd et al., "Experimental study of the behavioural mechanisms
underlying self-organization in human crowds", Proc. R. Soc. B 276, 2009, with the figures of
HuNavSim's evaluator (its factor is 2.1, where the paper fits 4.5).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from navigation import Motion
from navigation.quadrature import NODES_5, WEIGHTS_5

Array = NDArray[np.float64]

FACTOR, LAMBDA, GAMMA, N, N_PRIME = 2.1, 2.0, 0.35, 2.0, 3.0
"""Metres per square second, and figures without unit."""

STRAIGHT = 1e-9
"""Radians. Where D is no further from the line between two bodies, there is no turning."""

LONGEST = 0.25
"""Seconds. Stretches are halved until they are no longer than this."""

_NODES, _WEIGHTS = np.array(NODES_5), np.array(WEIGHTS_5)


def social_force(at: Array, velocity: Array, other: Array, others_velocity: Array) -> Array:
    """Return the force per mass (m/s²) on a body from another one: (N, 2).

    Of both the places (m) and velocities (m/s), each (N, 2).
    """
    # In the paper's terms `towards` is D = λ Δv + e, `angle` θ, from D to e, and `width` B = γ |D|;
    # the force is that of slowing down, along D, and that of turning, across it.
    apart = other - at
    distance = np.maximum(np.hypot(*apart.T), 1e-9)
    direction = apart / distance[:, None]
    towards = LAMBDA * (velocity - others_velocity) + direction
    length = np.maximum(np.hypot(*towards.T), 1e-9)
    along = towards / length[:, None]
    left = np.column_stack([-along[:, 1], along[:, 0]])
    across = along[:, 0] * direction[:, 1] - along[:, 1] * direction[:, 0]
    angle = np.arctan2(across, (along * direction).sum(1))
    # Towards either side, if D is along e or against it: rounding must not say which.
    side = np.where(np.abs(across) > STRAIGHT, np.sign(across), 0.0)
    width = GAMMA * length
    slowing = -np.exp(-distance / width - (N_PRIME * width * angle) ** 2)
    turning = -side * np.exp(-distance / width - (N * width * angle) ** 2)
    return np.asarray(FACTOR * (slowing[:, None] * along + turning[:, None] * left))


def social_work(
    motion: Motion,
    others: Sequence[tuple[Motion, tuple[float, float]]],
    span: tuple[float, float],
) -> float:
    """Return ∫ |force on the body| + Σ |force of the body on each other| dt, in m/s.

    Each of `others` has the span (seconds) in which they are there, and the body has one.
    """
    begin, end = span
    # Between these cuts nobody's motion goes over into another polynomial, comes or goes: the
    # integrand is smooth there, and Gauss-Legendre's five nodes, exact up to the ninth degree,
    # need only short stretches; across a cut they would lose that order.
    cuts = {begin, end}
    for one, (since, until) in [(motion, span), *others]:
        times = {since, until, *(t for piece in one.pieces for t in piece[:2])}
        cuts |= {t for t in times if begin < t < end}
    edges = np.array(sorted(cuts))
    if len(edges) < 2 or not others:
        return 0.0
    shares = np.maximum(np.ceil(np.diff(edges) / LONGEST).astype(int), 1)
    halves = np.repeat(np.diff(edges) / shares / 2, shares)
    first = np.repeat(edges[:-1], shares)
    number = np.arange(len(first)) - np.repeat(np.cumsum(shares) - shares, shares)
    middles = first + (2 * number + 1) * halves
    times = (middles[:, None] + halves[:, None] * _NODES).ravel()
    weights = (halves[:, None] * _WEIGHTS).ravel()
    at, velocity = motion.position(times), motion.velocity(times)
    felt, given = np.zeros((len(times), 2)), np.zeros(len(times))
    for other, (since, until) in others:
        there = (times >= since) & (times < until)
        mine = at[there], velocity[there]
        theirs = other.position(times[there]), other.velocity(times[there])
        felt[there] += social_force(*mine, *theirs)
        given[there] += np.hypot(*social_force(*theirs, *mine).T)
    return float(((np.hypot(*felt.T) + given) * weights).sum())
