from navigation.kernels.throng cimport Throng

cdef class Movers:
    cdef readonly Throng throng
    cdef readonly double now
    cdef readonly list[Py_ssize_t] indices
    cdef readonly list[list[double]] tables
    cdef readonly list[double] boxes
    cdef readonly list[double] radii
    cdef bytearray among
    cpdef bint meet(self, Py_ssize_t k, list[double] table, list[double] box) noexcept
    cdef double met(
        self, Py_ssize_t i, list[double] table, list[double] box, double own
    ) noexcept
    cpdef Py_ssize_t first_hit(self, Py_ssize_t i) except -2
    cpdef Py_ssize_t first_other(
        self, Py_ssize_t k, list[double] table, list[double] box
    ) except -2
