from navigation.kernels.cubics cimport *

cdef class Gauge:
    cdef double radius, height, along, across, rounding, reach
    cdef NearestPoint nearest(self, double x, double y) noexcept
    cdef double over(self, double away) noexcept
    cdef Range distances(self, RelativeMotion c, double slope, double curve) noexcept
