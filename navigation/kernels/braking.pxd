from libc.math cimport sqrt
from navigation.kernels.cubics cimport *
from navigation.kernels.pieces cimport instant, merge_axes, rest

cdef double _STANDS, _EASES

cpdef bint stands(double velocity, double acceleration) noexcept
cpdef Numbers braking(
    double position, double velocity, double acceleration, double top, double jerk
)
cdef class Stops:
    cpdef Numbers table(self, Numbers motion, double t)

cdef class AxisStops(Stops):
    cdef Numbers limits
    cpdef Numbers after(self, list[double] state, double t)
    cdef Numbers _stop(self, Cubic x, Cubic y, Cubic r, double t)

cdef class LaneStops(Stops):
    cdef double x, y, c, s, heading, low, high, top
    cpdef Numbers after(self, double q, double v, double a, double t)
