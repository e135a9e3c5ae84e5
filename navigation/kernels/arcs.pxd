from libc.math cimport ceil, cos, pow, sin, sqrt
from navigation.kernels.braking cimport braking
from navigation.kernels.cubics cimport *
from navigation.kernels.pieces cimport between, merge_axes

cdef double _ARC, _HASTE, _LEAST_HASTE, _SHARE, _BEND, _CHANGE, _SHORTEST
cdef double _NODE_1, _NODE_2, _NODE_3, _WEIGHT_1, _WEIGHT_2, _WEIGHT_3

cpdef Numbers twist_axis(
    double velocity,
    double acceleration,
    double target,
    double seconds,
    double top,
    double rate,
    double jerk,
)
cpdef Numbers arc_table(
    list[Numbers] axes,
    double since,
    double x,
    double y,
    double rotation,
    double start,
    double top_speed,
)
cdef PosePiece _driven(PosePiece piece, PosePiece part, double low, double high) noexcept
cdef double _gauss(double a, double b, double c, double d, double e, double f) noexcept
cdef Cubic _hermite(double p, double v, double w, double h, double step) noexcept
cdef Position _velocity(PosePiece part, Cubic heading, double u) noexcept
cdef Py_ssize_t _cubics_of(PosePiece part, double top_speed) noexcept
cdef bint _rests(Cubic c) noexcept
cdef double _top_speed(Cubic c, double length) noexcept
cdef double _top_acceleration(Cubic c, double length) noexcept
