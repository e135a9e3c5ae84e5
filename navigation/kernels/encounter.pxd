from navigation.kernels.follower cimport Follower
from navigation.kernels.gauge cimport Course, Gauge
from navigation.kernels.numbers cimport Numbers
from navigation.kernels.odometer cimport TaylorModel, PathLength

cdef double _INFINITE
cdef Course _NO_COURSE
cdef Numbers _NONE
cdef Py_ssize_t _SOME
cdef double _NEAR

cdef class EncounterBounds:
    cdef Follower person
    cdef Follower machine
    cdef list[Gauge] gauges
    cdef Course course
    cdef tuple ways
    cdef double since
    cdef double until
    cdef bint started
    cdef double x0
    cdef double x1
    cdef double x2
    cdef double x3
    cdef double y0
    cdef double y1
    cdef double y2
    cdef double y3
    cdef double slack
    cdef double near
    cdef double far
    cdef double offset
    cdef double lower
    cdef double upper
    cdef Numbers ends
    cdef Py_ssize_t left
    cdef tuple paths(self)
    cdef int start(self, double begin) except? -1
    cdef bint go_on(self, double end) except? -1
    cdef bint next_interval(self, double end) except? -1
    cdef bint halve(self) except? -1
    cdef int look(self, double begin, double end) noexcept
    cdef int apart_over(self, double begin, double end, double slope, double curve) noexcept
    cdef int measure(self, double middle, double half, double slope, double curve) noexcept
    cdef double bend(self, double x, double y, double vx, double vy, double ax, double ay, double half, double curve, double bend) noexcept
    cdef int measure_surfaces(self, double middle, double half, double slope, double curve) noexcept
    cdef int close_in(self, double begin, double end) noexcept
