from navigation.kernels.numbers cimport Doubles, Numbers

cdef double _INFINITE
cdef Py_ssize_t _WIDTH
cdef double _STANDS
cdef double _EASES

cpdef bint stands(double velocity, double acceleration) noexcept
cpdef Numbers braking(
    double position, double velocity, double acceleration, double top, double jerk
)
cdef Py_ssize_t _set(
    Doubles row,
    Py_ssize_t o,
    double duration,
    double position,
    double velocity,
    double acceleration,
    double jerk,
) noexcept

cdef class Stops:
    cpdef Numbers table(self, Numbers motion, double t)

cdef class AxisStops(Stops):
    cdef Numbers limits
    cpdef Numbers table(self, Numbers motion, double t)
    cpdef Numbers after(self, Numbers state, double t)

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
