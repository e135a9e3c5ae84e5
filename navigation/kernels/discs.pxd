from libc.math cimport sqrt
from navigation.kernels.cubics cimport *
from navigation.kernels.numbers cimport *

cdef Py_ssize_t _R
cdef double _RESOLUTION, _JUST_NOW

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
cpdef double distance_travelled(Numbers table, double since, double t) noexcept
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
cpdef double first_conflict(
    Numbers one, Numbers other, double least, double begin, double until
) noexcept
cdef double conflict_from(
    Numbers one,
    Numbers other,
    double least,
    double begin,
    double until,
    Py_ssize_t i,
    Py_ssize_t j,
) noexcept
cdef bint _is_apart(Cubic c, double duration, double least) noexcept
cdef double _first_within(Cubic x, Cubic y, double duration, double least) noexcept
cdef double _least_on_leaving(Cubic x, Cubic y, double width) noexcept
cdef double _entry(Cubic x, Cubic y, double duration, double least) noexcept
