"""Gauss and Legendre's places and weights on -1 … 1, by which an integral is a sum.

They are written out: worked out by `numpy.polynomial` their last bits depend on its LAPACK.
"""

from __future__ import annotations

NODES_5 = (
    -0.906179845938664,
    -0.5384693101056831,
    0.0,
    0.5384693101056831,
    0.906179845938664,
)
WEIGHTS_5 = (
    0.23692688505618928,
    0.4786286704993663,
    0.5688888888888887,
    0.4786286704993663,
    0.23692688505618928,
)
"""Of 5 places; exact for polynomials up to the degree 9."""

NODES_8 = (
    -0.9602898564975362,
    -0.7966664774136267,
    -0.525532409916329,
    -0.18343464249564978,
    0.18343464249564978,
    0.525532409916329,
    0.7966664774136267,
    0.9602898564975362,
)
WEIGHTS_8 = (
    0.10122853629037706,
    0.22238103445337443,
    0.3137066458778869,
    0.36268378337836166,
    0.36268378337836166,
    0.3137066458778869,
    0.22238103445337443,
    0.10122853629037706,
)
"""Of 8 places; exact for polynomials up to the degree 15."""
