from navigation.kernels.numbers cimport Doubles, Numbers

cdef double _INFINITE
cdef Py_ssize_t _WIDTH
cdef double _SHORTEST

cpdef tuple evaluate(Numbers table, Py_ssize_t row, double t, bint moving)
cdef double value_at(Doubles table, Py_ssize_t o, double t) noexcept
cdef double rate_at(Doubles table, Py_ssize_t o, double t) noexcept
cdef double bend_at(Doubles table, Py_ssize_t o, double t) noexcept
cpdef Numbers rest(double begin, double end, double x, double y, double rotation)
cdef double _parted(Doubles table, Py_ssize_t p, Doubles after, Py_ssize_t o) noexcept
cpdef Numbers merge_axes(list[Numbers] axes, double start)
cdef int _shift(
    Doubles table,
    Py_ssize_t k,
    Doubles phases,
    Py_ssize_t row,
    double u,
    bint moving,
) noexcept
cpdef Numbers between(Numbers table, double begin, double end)
cdef int _stand(
    Doubles found,
    Py_ssize_t count,
    Doubles table,
    Py_ssize_t o,
    double t,
    double begin,
    double end,
) noexcept
cdef int _set_later(
    Doubles found, Py_ssize_t k, Doubles table, Py_ssize_t o, double u
) noexcept

cdef class Pack:
    cdef readonly Py_ssize_t count
    cdef Numbers kept
    cdef Numbers last
