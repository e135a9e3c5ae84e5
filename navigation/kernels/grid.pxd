cimport cython
from libc.math cimport floor, sqrt
from navigation.kernels.numbers cimport *

cdef Py_ssize_t _STRAIGHT
cdef Py_ssize_t _ACROSS
cdef Py_ssize_t _BUCKETS
cdef Py_ssize_t _SOME
cdef Py_ssize_t _FAR

cdef class Cells:
    cdef double width
    cdef object whole
    cdef object within
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

@cython.locals(
    costs="int[::1]",
    came="int[::1]",
    tops="int[::1]",
    above="int[::1]",
    below="int[::1]",
)
cpdef list grid_path(
    bytearray blocked, Py_ssize_t columns, Py_ssize_t start, Py_ssize_t goal
)
