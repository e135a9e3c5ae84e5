from navigation.kernels.numbers cimport Numbers

cdef double _INFINITE
cdef Py_ssize_t _WIDTH
cdef double _SHORTEST

cpdef tuple evaluate(list[double] table, Py_ssize_t row, double t, bint moving)
cdef double value_at(list[double] table, Py_ssize_t o, double t) noexcept
cdef double rate_at(list[double] table, Py_ssize_t o, double t) noexcept
cdef double bend_at(list[double] table, Py_ssize_t o, double t) noexcept
cdef int _append_shifted(list[double] table, list[double] phases, Py_ssize_t row, double u, bint moving) except? -1
cdef int _append_still(list[double] found, list[double] table, Py_ssize_t o, double t, double begin, double end) except? -1
cdef int _append_later(list[double] found, list[double] table, Py_ssize_t k, double u) except? -1
cpdef list[double] merge_axes(list[list[double]] axes, double start)
cdef double _parted(list[double] table, Py_ssize_t p, list[double] after, Py_ssize_t o) noexcept
cpdef list[double] cut(list[double] table, double begin, double end)

cdef class Pack:
    cdef readonly object masks
    cdef Numbers kept
    cdef Py_ssize_t count
    cdef list[double] last
