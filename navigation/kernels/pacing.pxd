cdef double _SHORT
cdef double _DEVIATION
cdef double _HAIR

cpdef bint walk_table(
    list[double] corners,
    list[double] tops,
    double start,
    double initial_speed,
    double max_speed,
    double acceleration,
    list[double] table,
) except -1
cpdef void stand(
    list[double] table, double since, double until, double x, double y
) except *
cdef double bend_speed(double cosine, double shorter, double acceleration) noexcept
cdef double _leg(
    list[double] table,
    double t,
    double x,
    double y,
    double c,
    double s,
    double length,
    double u,
    double w,
    double top,
    double acceleration,
) except? -1.0
cdef double _phase(
    list[double] table,
    double t,
    double x,
    double y,
    double c,
    double s,
    double gone,
    double duration,
    double v,
    double acceleration,
) except? -1.0
cdef int _add(
    list[double] table,
    double begin,
    double end,
    double x,
    double vx,
    double ax,
    double y,
    double vy,
    double ay,
) except -1
