from navigation.kernels.cubics cimport *
from navigation.kernels.discs cimport conflict_from

cdef double _SHARE, _HAIR

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
