cdef Py_ssize_t _R
cdef Py_ssize_t _X
cdef Py_ssize_t _Y
cdef double _SLOW

cpdef double speed_behind(
    double along, double away, double touch, double walks_on, double gap, double ahead
) noexcept
cdef double _at(list[double] table, Py_ssize_t o, double u) noexcept
