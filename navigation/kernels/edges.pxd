cdef double _square(double px, double py, double dx, double dy, double length) noexcept
cdef double _square_to(
    double px, double py, double qx, double qy, double x, double y
) noexcept
