cpdef double speed_behind(
    double along, double away, double touch, double walks_on, double gap, double ahead
) noexcept
cdef double _at(list[double] table, Py_ssize_t o, double u) noexcept
