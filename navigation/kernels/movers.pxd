from navigation.kernels.discs cimport first_but, met
from navigation.kernels.numbers cimport *
from navigation.kernels.throng cimport Throng

cdef class Movers:
    cdef readonly Throng throng
    cdef readonly double now
    cdef readonly list[Py_ssize_t] indices
    cdef readonly list[Numbers] tables
    cdef readonly Numbers boxes, radii
    cdef bytearray among
    cpdef bint meet(self, Py_ssize_t k, Numbers table, Numbers box) noexcept
    cdef double met(
        self, Py_ssize_t i, Numbers table, Numbers box, double own
    ) noexcept
    cpdef Py_ssize_t first_hit(self, Py_ssize_t i) except -2
    cpdef Py_ssize_t first_other(
        self, Py_ssize_t k, Numbers table, Numbers box
    ) except -2
