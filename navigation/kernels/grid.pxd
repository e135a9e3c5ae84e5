from libc.math cimport floor, sqrt
from navigation.kernels.numbers cimport *

cdef Py_ssize_t _STRAIGHT, _ACROSS, _BUCKETS, _SOME, _FAR

cdef class Cells:
    cdef double width
    cdef object whole, within
    cdef dict known
    cpdef bint has(self, double x, double y) except -1

cpdef int block_discs(
    bytearray blocked,
    Py_ssize_t columns,
    double low_x,
    double low_y,
    double width,
    Numbers discs,
    double spare,
) except -1
cpdef bint covers(Numbers discs, double x, double y) noexcept
cpdef Numbers middles(Numbers discs)

cdef Py_ssize_t _estimate(Py_ssize_t cell, Py_ssize_t goal, Py_ssize_t columns) noexcept

cpdef list grid_path(
    bytearray blocked, Py_ssize_t columns, Py_ssize_t start, Py_ssize_t goal
)
