"""Social work: how much bodies would push people away, in the social force model.

The force is that of M. Moussaïd et al., "Experimental study of the behavioural mechanisms
underlying self-organization in human crowds", Proc. R. Soc. B 276, 2009, with the figures of
HuNavSim's evaluator (its factor is 2.1, where the paper fits 4.5).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

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

_AT_ONCE = 1024
"""Stretches that are worked on at once: what is known of a pair in them stays in the cache."""

_NODES, _WEIGHTS = np.array(NODES_5), np.array(WEIGHTS_5)


def social_force(apart: Array, velocity: Array) -> Array:
    """Return the force per mass (m/s²) on a body from another one: (2, N).

    `apart` is from the body to the other one (m), `velocity` the body's less the other's (m/s),
    each (2, N). The force of the body on the other one is its opposite.
    """
    # In the paper's terms `towards` is D = λ Δv + e, `angle` θ, from D to e, and `width` B = γ |D|;
    # the force is that of slowing down, along D, and that of turning, across it. As the other one
    # has it, e and Δv are the opposite: so is D, and θ is the same.
    distance = np.maximum(_length(apart), 1e-9)
    direction = apart / distance
    towards = LAMBDA * velocity + direction
    length = np.maximum(_length(towards), 1e-9)
    along = towards / length
    across = along[0] * direction[1] - along[1] * direction[0]
    angle = np.arctan2(across, along[0] * direction[0] + along[1] * direction[1])
    # Towards either side, if D is along e or against it: rounding must not say which.
    side = np.where(np.abs(across) > STRAIGHT, np.sign(across), 0.0)
    width = GAMMA * length
    nearness, turn = -distance / width, (width * angle) ** 2
    slowing = -FACTOR * np.exp(nearness - N_PRIME**2 * turn)
    turning = -FACTOR * side * np.exp(nearness - N**2 * turn)
    x, y = along
    return np.stack((slowing * x - turning * y, slowing * y + turning * x))


def social_work(
    bodies: Sequence[tuple[Motion, tuple[float, float]]], pairs: Sequence[tuple[int, int]]
) -> Array:
    """Return ∫ |Σ force of others on the body| + Σ |force of the body on each other| dt, m/s: (B,).

    Each of the bodies has the span (seconds) in which it is there; `pairs` are their indices, each
    pair once.
    """
    work = np.zeros(len(bodies))
    spans = np.array([span for _, span in bodies])
    for begins, halves in _stretches(bodies):
        u = halves[:, None] * (1 + _NODES)
        cubics = np.array([motion.cubics(begins)[:, :2] for motion, _ in bodies])
        c0, c1, c2, c3 = np.moveaxis(cubics, (3, 2), (0, 2))[..., None]
        shape = (len(bodies), 2, u.size)
        at = (c0 + u * (c1 + u * (c2 + u * c3))).reshape(shape)
        velocity = (c1 + u * (2 * c2 + u * 3 * c3)).reshape(shape)
        felt, given = np.zeros(shape), np.zeros((len(bodies), u.size))
        there = np.searchsorted(begins, spans) * u.shape[1]
        for one, other in pairs:
            both = slice(max(there[one, 0], there[other, 0]), min(there[one, 1], there[other, 1]))
            force = social_force(
                at[other, :, both] - at[one, :, both],
                velocity[one, :, both] - velocity[other, :, both],
            )
            felt[one, :, both] += force
            felt[other, :, both] -= force
            size = _length(force)
            given[one, both] += size
            given[other, both] += size
        weights = (halves[:, None] * _WEIGHTS).ravel()
        work += ((_length(felt.swapaxes(0, 1)) + given) * weights).sum(1)
    return work


def _stretches(
    bodies: Sequence[tuple[Motion, tuple[float, float]]],
) -> Iterator[tuple[Array, Array]]:
    """Yield begins and half durations (S,), in seconds, of some stretches after others.

    Between two cuts nobody's motion goes over into another polynomial, comes or goes: the integrand
    is smooth there, and Gauss-Legendre's five nodes, exact up to the ninth degree, need only short
    stretches; across a cut they would lose that order.
    """
    spans = [t for _, span in bodies for t in span]
    changes = (t for motion, _ in bodies for piece in motion.pieces for t in piece[:2])
    cuts = {*spans, *(t for t in changes if min(spans) < t < max(spans))}
    edges = np.array(sorted(cuts))
    shares = np.maximum(np.ceil(np.diff(edges) / LONGEST).astype(int), 1)
    halves = np.repeat(np.diff(edges) / shares / 2, shares)
    number = np.arange(len(halves)) - np.repeat(np.cumsum(shares) - shares, shares)
    begins = np.repeat(edges[:-1], shares) + 2 * number * halves
    for first in range(0, len(begins), _AT_ONCE):
        part = slice(first, first + _AT_ONCE)
        yield begins[part], halves[part]


def _length(vectors: Array) -> Array:
    """Return the lengths (...) of vectors (2, ...)."""
    x, y = vectors
    return np.asarray(np.sqrt(x * x + y * y))
