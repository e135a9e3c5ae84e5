cdef double _INFINITE

cdef class Course:
    cdef double x
    cdef double y
    cdef double vx
    cdef double vy
    cdef double ax
    cdef double ay
    cdef double spin
    cdef double half
    cdef double bend
    cdef double jolt
    cdef double twist
    cdef double swing

cdef class Gauge:
    cdef double radius
    cdef double height
    cdef double along
    cdef double across
    cdef double rounding
    cdef double reach
    cdef double low
    cdef double high
    cdef double away
    cdef double at_x
    cdef double at_y
    cdef double look(self, double x, double y) noexcept
    cdef double over(self, double away) noexcept
    cdef int range(self, Course c, double slope, double curve) noexcept
