cpdef bint touches(
    list[double] edges, double ax, double ay, double bx, double by, double radius
) except -1
cdef double _square(double px, double py, double dx, double dy, double length) noexcept
cdef double _square_to(
    double px, double py, double qx, double qy, double x, double y
) noexcept
