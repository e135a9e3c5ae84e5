cimport cython

from navigation.kernels.numbers cimport Numbers

cdef Py_ssize_t _STRAIGHT
cdef Py_ssize_t _ACROSS
cdef Py_ssize_t _BUCKETS
cdef Py_ssize_t _SOME
cdef Py_ssize_t _FAR
cdef Py_ssize_t _UNKNOWN

cdef class Cells:
    cdef double width
    cdef object whole
    cdef object within
    cdef dict known
    cpdef bint has(self, double x, double y) except -1

cdef Py_ssize_t _estimate(Py_ssize_t cell, Py_ssize_t goal, Py_ssize_t columns) noexcept

cpdef void block_discs(
    bytearray blocked,
    Py_ssize_t columns,
    double low_x,
    double low_y,
    double width,
    Numbers discs,
    double spare,
) except *
cpdef bint covers(Numbers discs, double x, double y) noexcept
cpdef Numbers middles(Numbers discs)
@cython.locals(
    costs="long long[::1]",
    came="long long[::1]",
    tops="long long[::1]",
    below="long long[::1]",
    above="long long[::1]",
)
cpdef list grid_path(
    bytearray blocked, Py_ssize_t columns, Py_ssize_t start, Py_ssize_t goal
)
