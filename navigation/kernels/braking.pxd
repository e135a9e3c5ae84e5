from libc.math cimport sqrt
from navigation.kernels.cubics cimport *
from navigation.kernels.numbers cimport *
from navigation.kernels.pieces cimport instant, merge_axes, rest

cdef double _STANDS
cdef double _EASES

cpdef bint stands(double velocity, double acceleration) noexcept
cpdef Numbers braking(
    double position, double velocity, double acceleration, double top, double jerk
)
cdef class Stops:
    cpdef Numbers table(self, Numbers motion, double t)

cdef class AxisStops(Stops):
    cdef Numbers limits
    cpdef Numbers table(self, Numbers motion, double t)
    cpdef Numbers after(self, list[double] state, double t)
    cdef Numbers _stop(self, Cubic x, Cubic y, Cubic r, double t)

cdef class LaneStops(Stops):
    cdef double x
    cdef double y
    cdef double c
    cdef double s
    cdef double heading
    cdef double low
    cdef double high
    cdef double top
    cpdef Numbers table(self, Numbers motion, double t)
    cpdef Numbers after(self, double q, double v, double a, double t)
