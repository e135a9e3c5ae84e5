from libc.math cimport copysign, cos, sin, sqrt
from navigation.kernels.cubics cimport *
from navigation.kernels.odometer cimport Odometer, enclosure_of, speed_along

cdef Numbers _NONE
cdef Py_ssize_t _SOME
cdef double _NEAR, _SURFACE_ROUNDING

cdef class Gauge:
    cdef double radius, height, along, across, rounding, reach
    cdef Numbers corners
    cdef NearestPoint nearest(self, double x, double y) noexcept
    cdef double over(self, double away) noexcept
    cdef Range distances(self, RelativeMotion c, double slope, double curve) noexcept

cdef class PolygonGauge(Gauge):
    pass

cdef double nearest_surface(list[Gauge] gauges, double x, double y) noexcept

cdef class Follower:
    cdef Numbers table
    cdef Py_ssize_t rows, row
    cdef double since, begin, end, entered
    cdef Cubic x, y, rotation
    cdef int seek(self, double t) except -1
    cdef int go_on(self) except -1
    cdef int enter(self, double t) noexcept
    cdef Range speeds(self, double begin, double end) noexcept
    cdef Range turning(self, double begin, double end) noexcept
    cdef TaylorModel speed_over(self, double begin, double end) noexcept

cdef class Encounter:
    cdef Follower person, machine
    cdef list[Gauge] gauges
    cdef object _person, _machine
    cdef Odometer _human, _robot
    cdef readonly double begin, end
    cdef bint started
    cdef Cubic x, y
    cdef double slack, lower, upper
    cdef Numbers ends
    cdef Py_ssize_t left
    cpdef int come_to(self, double begin) except -1
    cpdef bint next_stretch(self, double end) except -1
    cdef bint next_interval(self, double end) except -1
    cdef bint halve(self) except -1
    cdef bint divide(self, double share) except -1
    cdef Closest closest(self, double begin, double end, double slope, double curve) noexcept
    cdef Closest _between_centres(self, double u, double half, double slope, double curve) noexcept
    cdef Range _between_surfaces(self, double u, double half, double slope, double curve) noexcept
    cdef Range approach(self, double begin, double end) noexcept

cdef double _lowest_on_line(Cubic x, Cubic y, double half, double slope) noexcept
cdef double _deviation_of_distance(Cubic x, Cubic y, double half, double curve) noexcept
