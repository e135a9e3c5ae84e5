from libc.math cimport sqrt
from navigation.kernels.cubics cimport *
from navigation.kernels.numbers cimport *

cdef double _SLOW

cpdef Py_ssize_t followed(
    list[Py_ssize_t] near,
    list[Numbers] tables,
    Numbers radii,
    double t,
    double sees,
    double x,
    double y,
    double c,
    double s,
    double own,
    double gap,
    double ahead,
    double top_speed,
    double same_way,
    double beside,
    list[Py_ssize_t] slow,
) except -2
cdef double speed_behind(
    double along, double away, double touch, double walks_on, double gap, double ahead
) noexcept
