from libc.math cimport atan2, sqrt
from navigation.kernels.cubics cimport *
from navigation.kernels.numbers cimport *

cdef Py_ssize_t _ROW, _WIDTH, _PHASES
cdef double _SHORT, _DEVIATION, _HAIR, _ROUNDING

cdef struct PathLeg:
    double x, y, c, s, length, top, first

cdef struct SpeedLimits:
    double start, initial_speed, max_speed, acceleration

ctypedef PathLeg* PathLegs

cdef inline PathLegs _legs(Numbers table, Py_ssize_t o) noexcept:
    return <PathLeg*> (table.data.as_doubles + o)

cpdef Numbers walk_table(
    Numbers corners,
    Numbers tops,
    double since,
    double start,
    double initial_speed,
    double max_speed,
    double acceleration,
    Numbers lead,
)
cdef Py_ssize_t draw(
    Numbers corners,
    Py_ssize_t count,
    Numbers tops,
    double since,
    double start,
    double initial_speed,
    double max_speed,
    double acceleration,
    Numbers lead,
    Numbers table,
) except -1
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
cdef PlanarPiece _rest_from(double t, double x, double y) noexcept
cdef Py_ssize_t _plan(
    Numbers corners, Py_ssize_t count, Numbers tops, SpeedLimits pace, PathLegs leg
) noexcept
cdef double bend_speed(double cosine, double shorter, double acceleration) noexcept
cdef Py_ssize_t _walk(
    PlanarPieces row, Py_ssize_t k, PathLeg leg, double u, double w, double acceleration
) noexcept
cdef Py_ssize_t _add_phase(
    PlanarPieces row, Py_ssize_t k, PathLeg leg, double duration, Cubic way
) noexcept
