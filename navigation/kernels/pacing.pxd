from navigation.kernels.numbers cimport Doubles, Numbers

cdef Py_ssize_t _R
cdef Py_ssize_t _PIECE
cdef Py_ssize_t _LEG
cdef Py_ssize_t _PHASES
cdef double _SHORT
cdef double _DEVIATION
cdef double _HAIR

cpdef Numbers walk_table(
    Numbers corners,
    Numbers tops,
    double since,
    double start,
    double initial_speed,
    double max_speed,
    double acceleration,
    Numbers lead,
)
cpdef Numbers turned(Numbers table, double heading)
cdef double bend_speed(double cosine, double shorter, double acceleration) noexcept
cdef Py_ssize_t _plan(
    Numbers corners,
    Numbers tops,
    double initial_speed,
    double max_speed,
    double acceleration,
    Doubles leg,
    Doubles cap,
) noexcept
cdef Py_ssize_t _walk(
    Doubles row,
    Py_ssize_t o,
    Doubles leg,
    Py_ssize_t i,
    double u,
    double w,
    double acceleration,
) noexcept
cdef Py_ssize_t _phase(
    Doubles row,
    Py_ssize_t o,
    Doubles leg,
    Py_ssize_t i,
    double gone,
    double duration,
    double v,
    double acceleration,
) noexcept
