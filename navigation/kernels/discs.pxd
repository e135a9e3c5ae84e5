cdef Py_ssize_t _R
cdef Py_ssize_t _PIECE
cdef double _RESOLUTION
cdef double _JUST_NOW

cpdef list[Py_ssize_t] within_bounds(
    list[double] boxes, double low_x, double low_y, double high_x, double high_y
)
cpdef double gone(list[double] table, double since, double t) noexcept
cpdef Py_ssize_t first_met(
    list[double] table,
    list[double] box,
    list[Py_ssize_t] near,
    list[list[double]] tables,
    list[double] boxes,
    list[double] radii,
    double own,
    double begin,
    list[double] when,
) except -2
cpdef Py_ssize_t first_but(
    list[double] table,
    list[double] box,
    list[list[double]] tables,
    list[double] boxes,
    list[double] radii,
    double own,
    double begin,
    bytearray apart,
) except -2
cdef double met(
    list[double] table,
    list[double] box,
    list[list[double]] tables,
    list[double] boxes,
    list[double] radii,
    double own,
    double begin,
    double until,
    Py_ssize_t k,
) noexcept
cdef double distance(list[double] a, list[double] b, double t) noexcept
cdef double _meeting(
    list[double] a,
    list[double] b,
    double least,
    double begin,
    double until,
    Py_ssize_t row,
    Py_ssize_t other_row,
) noexcept
cdef double _within(
    double x0,
    double x1,
    double x2,
    double x3,
    double y0,
    double y1,
    double y2,
    double y3,
    double duration,
    double least,
) noexcept
cdef double _entered(
    double x, double vx, double y, double vy, double duration, double least
) noexcept
cdef int _widen(
    list[double] box, Py_ssize_t axis, list[double] pieces, Py_ssize_t o, double u
) except -1
