from navigation.kernels.numbers cimport Numbers

cdef double _INFINITE
cdef Py_ssize_t _WIDTH
cdef double _STANDS
cdef double _EASES

cpdef bint stands(double velocity, double acceleration) noexcept
cpdef list[double] braking(
    double position, double velocity, double acceleration, double top, double jerk
)
cdef int _add(
    list[double] rows,
    double duration,
    double position,
    double velocity,
    double acceleration,
    double jerk,
) except -1

cdef class Stops:
    cpdef Numbers table(self, Numbers motion, double t)

cdef class AxisStops(Stops):
    cdef list[double] limits
    cpdef Numbers table(self, Numbers motion, double t)
    cpdef Numbers after(self, list[double] state, double t)

cdef class LaneStops(Stops):
    cdef double x
    cdef double y
    cdef double c
    cdef double s
    cdef double heading
    cdef double low
    cdef double high
    cdef double top
    cpdef Numbers table(self, Numbers motion, double t)
    cpdef Numbers after(self, double q, double v, double a, double t)
