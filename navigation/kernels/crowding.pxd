from navigation.kernels.numbers cimport Numbers

cdef Py_ssize_t _R
cdef double _SHARE
cdef double _HAIR

cpdef int see(
    list[Numbers] tables,
    list[double] times,
    long long[::1] rows,
    double[::1] xs,
    double[::1] ys,
    double[::1] boxes,
) except -1
cpdef tuple nearest_seen(
    const double[::1] xs,
    const double[::1] ys,
    const double[::1] boxes,
    Py_ssize_t first,
    list[double] radii,
    list[double] steps,
    list[list[double]] jumps,
    double best,
)
cpdef list nearer_between(
    const double[::1] xs,
    const double[::1] ys,
    const double[::1] boxes,
    Py_ssize_t first,
    list[double] radii,
    list[double] steps,
    list[list[double]] jumps,
    list[double] times,
    list[Numbers] tables,
    double best,
)
cdef double _between(const double[::1] boxes, Py_ssize_t i, Py_ssize_t j) noexcept
cdef double _distance(
    const double[::1] xs,
    const double[::1] ys,
    Py_ssize_t i,
    Py_ssize_t j,
) noexcept
cdef Py_ssize_t _passed(
    Py_ssize_t k,
    double spare,
    double step,
    list[double] jumps,
    list[double] other_jumps,
    Py_ssize_t count,
) noexcept
cdef Py_ssize_t _next(list[double] jumps, Py_ssize_t k, Py_ssize_t count) noexcept
cdef Py_ssize_t _row_at(Numbers table, Py_ssize_t row, double t) noexcept
