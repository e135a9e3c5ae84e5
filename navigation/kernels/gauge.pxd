from navigation.kernels.cubics cimport *
from navigation.kernels.numbers cimport *

cdef struct NearestPoint:
    double x, y, away, distance

cdef struct RelativeMotion:
    double x, y, vx, vy, ax, ay, spin, half, bend, jolt, twist, swing

cdef class Gauge:
    cdef double radius, height, along, across, rounding, reach
    cdef NearestPoint nearest(self, double x, double y) noexcept
    cdef double over(self, double away) noexcept
    cdef Range distances(self, RelativeMotion c, double slope, double curve) noexcept
