from libc.math cimport M_PI as pi, atan2, cos, isfinite, sin, sqrt, tan
from navigation.kernels.cubics cimport *
from navigation.kernels.discs cimport Swath

cdef Py_ssize_t _PHASES
cdef double _NOWHERE, _DEVIATION, _HAIR, _STANDS, _STRAIGHT, _NO_SPEED, _ROUNDING

cpdef bint is_place(object point) except -1
cdef bint _apart(tuple a, tuple b, double least) except -1
cdef bint _same_way(double wx, double wy, double vx, double vy) except -1
cdef bint _straight(tuple a, tuple b, tuple c) except -1
cpdef double corner_speed(tuple before, tuple corner, tuple after, double acceleration) except? -1
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
