from navigation.kernels.numbers cimport Doubles, Numbers

cdef Py_ssize_t _R
cdef Py_ssize_t _PIECE
cdef Py_ssize_t _LEG
cdef Py_ssize_t _PHASES
cdef double _SHORT
cdef double _DEVIATION
cdef double _HAIR
cdef double _ROUNDING

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
cdef Py_ssize_t draw(
    Numbers corners,
    Py_ssize_t count,
    Numbers tops,
    double since,
    double start,
    double initial_speed,
    double max_speed,
    double acceleration,
    Numbers lead,
    Numbers table,
) except -1
cpdef Numbers turned(Numbers table, double heading)
cdef double bend_speed(double cosine, double shorter, double acceleration) noexcept
cdef Py_ssize_t _plan(
    Doubles corner,
    Py_ssize_t count,
    Numbers tops,
    double initial_speed,
    double max_speed,
    double acceleration,
    Doubles leg,
    Py_ssize_t i,
) noexcept
cdef Py_ssize_t _walk(
    Doubles row,
    Py_ssize_t o,
    Py_ssize_t i,
    double u,
    double w,
    double acceleration,
) noexcept
cdef Py_ssize_t _phase(
    Doubles row,
    Py_ssize_t o,
    Py_ssize_t i,
    double gone,
    double duration,
    double v,
    double acceleration,
) noexcept
