from libc.math cimport atan2, sqrt
from navigation.kernels.cubics cimport *
from navigation.kernels.discs cimport Swath

cdef Py_ssize_t _PHASES
cdef double _SHORT, _DEVIATION, _HAIR, _ROUNDING

cpdef Numbers turned(Numbers table, double heading)
cdef Py_ssize_t draw_walk(
    Numbers corners,
    Py_ssize_t count,
    Numbers tops,
    SpeedLimits pace,
    double since,
    Numbers lead,
    Numbers table,
) except -1
cdef Py_ssize_t _plan(
    Positions corner, Py_ssize_t count, Numbers tops, SpeedLimits pace, PathLegs leg
) noexcept
cdef double bend_speed(double cosine, double shorter, double acceleration) noexcept
cdef Py_ssize_t _walk(
    PlanarPieces row, Py_ssize_t k, PathLeg leg, double u, double w, double acceleration
) noexcept
cdef Py_ssize_t _add_phase(
    PlanarPieces row, Py_ssize_t k, PathLeg leg, double duration, Cubic way
) noexcept
