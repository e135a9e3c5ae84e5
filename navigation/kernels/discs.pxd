from navigation.kernels.numbers cimport Doubles, Numbers

cdef Py_ssize_t _R
cdef Py_ssize_t _PIECE
cdef double _RESOLUTION
cdef double _JUST_NOW

cpdef list[Py_ssize_t] within_bounds(
    Numbers boxes,
    double low_x,
    double low_y,
    double high_x,
    double high_y,
    Py_ssize_t but=*,
)
cdef int stand(
    Doubles row, Py_ssize_t o, double since, double until, double x, double y
) noexcept
cpdef double gone(Numbers table, double since, double t) noexcept
cpdef Py_ssize_t first_met(
    Numbers table,
    Numbers box,
    list[Py_ssize_t] near,
    list[Numbers] tables,
    Numbers boxes,
    Numbers radii,
    double own,
    double begin,
    Numbers when,
) except -2
cpdef Py_ssize_t first_but(
    Numbers table,
    Numbers box,
    list[Numbers] tables,
    Numbers boxes,
    Numbers radii,
    double own,
    double begin,
    bytearray apart,
) except -2
cdef double met(
    Numbers table,
    Numbers box,
    list[Numbers] tables,
    Numbers boxes,
    Numbers radii,
    double own,
    double begin,
    double until,
    Py_ssize_t k,
) noexcept
cdef double distance(Numbers one, Numbers other, double t) noexcept
cdef double _meeting(
    Numbers one,
    Numbers other,
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
cdef double _parting(
    double x0,
    double x1,
    double x2,
    double x3,
    double y0,
    double y1,
    double y2,
    double y3,
    double since,
    double width,
) noexcept
cdef double _entered(
    double x, double vx, double y, double vy, double duration, double least
) noexcept
cdef int _widen(
    Doubles box, Py_ssize_t axis, Doubles row, Py_ssize_t o, double u
) noexcept
