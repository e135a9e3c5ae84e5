from libc.math cimport sqrt
from navigation.kernels.cubics cimport *

cdef double _RESOLUTION, _JUST_NOW, _ROUNDING, _FAR, _TOUCH

cdef class Swath:
    cdef public Numbers table, box

cpdef Swath swept(Numbers pieces, double begin, double since, double x, double y)

cdef class DiscMotions:
    cdef readonly double gap
    cdef readonly list[Numbers] tables
    cdef readonly Numbers boxes, radii, counted
    cpdef void add(self, Swath swath, double radius, double counted=*) except *
    cpdef void change(self, Py_ssize_t k, Swath swath) except *
    cpdef void shorten(self, Py_ssize_t count) except *
    cpdef Swath swath_of(self, Py_ssize_t k)
    cdef double met(
        self, Py_ssize_t k, Swath ahead, double own, double begin, double until
    ) noexcept
    cdef bint conflicts(self, Py_ssize_t k, Swath ahead, double own, double begin) noexcept
    cdef Meeting first_meeting(
        self, list[Py_ssize_t] near, Swath ahead, double own, double begin, double until
    ) noexcept
    cpdef bint free(self, list[Py_ssize_t] near, Swath ahead, double own, double begin) except -1
    cdef Py_ssize_t first_but(
        self,
        bytearray apart,
        list[Py_ssize_t] near,
        Swath ahead,
        double own,
        double begin,
    ) except -2

cdef class DiscWindow:
    cdef list[Numbers] tables
    cdef Numbers radii, steps
    cdef list[Numbers] jumps
    cdef list[Py_ssize_t] rows
    cdef Py_ssize_t first
    cdef Numbers times, xs, ys, boxes
    cdef double _between(self, Py_ssize_t i, Py_ssize_t j) noexcept
    cdef double _gap(self, Py_ssize_t i, Py_ssize_t j, Py_ssize_t k) noexcept
    cdef Py_ssize_t _passed(
        self, Py_ssize_t i, Py_ssize_t j, Py_ssize_t k, double spare, Py_ssize_t end
    ) noexcept
    cdef Py_ssize_t _next_jump(self, Py_ssize_t i, Py_ssize_t k, Py_ssize_t end) noexcept

cpdef list[Py_ssize_t] within_bounds(
    Numbers boxes, Numbers box, double margin, Py_ssize_t but=*
)
cdef bint covers(Numbers circles, double x, double y) noexcept
cdef double rests_from(Numbers table) noexcept
cdef double distance_travelled(Numbers table, double since, double t) noexcept
cdef double distance(Numbers one, Numbers other, double t) noexcept
cpdef double first_conflict(
    Numbers one, Numbers other, double least, double begin, double until
) noexcept
cdef double conflict_from(
    Numbers one,
    Numbers other,
    double least,
    double begin,
    double until,
    Py_ssize_t i,
    Py_ssize_t j,
    bint exact,
) noexcept
cdef bint _is_apart(Cubic c, double duration, double least) noexcept
cdef double _first_within(Cubic x, Cubic y, double duration, double least, bint exact) noexcept
cdef double _least_on_leaving(Cubic x, Cubic y, double width) noexcept
cdef double _entry(Cubic x, Cubic y, double duration, double least) noexcept
