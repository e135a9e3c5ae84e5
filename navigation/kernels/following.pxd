from libc.math cimport sqrt
from navigation.kernels.committed cimport CommittedMotions
from navigation.kernels.cubics cimport *

cdef double _SLOW

cdef class ChoiceParameters:
    cdef readonly double stride, farthest, looks_around, widest, shortest, phantom, faster
    cdef readonly double beside_after, past, other_side, brush, alike, closes_in, sees
    cdef readonly double least_speed, same_way, closes_up
    cdef readonly Numbers detours, widths, paces, delays, parts, files

cdef class Passer:
    cdef Py_ssize_t index
    cdef double top_speed, radius, comfort, time_gap, foresight, usual

cdef class CarFollowing:
    cdef CommittedMotions motions
    cdef Passer walker
    cdef ChoiceParameters parameters
    cdef Leader leader(self, list[Py_ssize_t] near, double t, CoursePlace here) except *
    cdef double speed_at(self, list[Py_ssize_t] near, double t, CoursePlace here) except? -1
    cdef Py_ssize_t followed(
        self, list[Py_ssize_t] near, double t, CoursePlace here, list[Py_ssize_t] slow
    ) except -2
    cdef Leader behind(self, Py_ssize_t k, double t, CoursePlace here) noexcept
    cdef double _speed_behind(
        self, double along, double away, double touch, double walks_on
    ) noexcept
