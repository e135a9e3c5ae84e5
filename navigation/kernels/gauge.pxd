from navigation.kernels.cubics cimport *
from navigation.kernels.numbers cimport *

cdef struct NearestPoint:
    double x, y, away, distance

cdef struct RelativeMotion:
    double x, y, vx, vy, ax, ay, spin, half, bend, jolt, twist, swing

cdef class Gauge:
    cdef double radius
    cdef double height
    cdef double along
    cdef double across
    cdef double rounding
    cdef double reach
    cdef NearestPoint nearest(self, double x, double y) noexcept
    cdef double over(self, double away) noexcept
    cdef Range distances(self, RelativeMotion c, double slope, double curve) noexcept
