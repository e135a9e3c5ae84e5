from libc.math cimport cos, sin
from navigation.kernels.cubics cimport *
from navigation.kernels.encounter cimport Encounter, Follower

cdef double _RESOLUTION, _TOUCH, _POINT, _ASIDE, _LEAST_SHARE
cdef int _NEVER, _PERHAPS, _ALWAYS

cdef class FieldSwitches:
    cdef Numbers sets
    cpdef list switches(self, object machine, double begin, double end)
    cdef Py_ssize_t applying(self, Follower machine, double lower, double upper) noexcept

cpdef tuple within_reach(Encounter encounter, double reach, double begin, double end)

cdef class FieldSearch:
    cdef Numbers edges
    cdef double reach
    cpdef list spans(
        self, Encounter encounter, double radius, double begin, double end, bint first
    )
    cdef FieldTouch touched(self, Encounter encounter, double radius, bint so_far) noexcept
    cdef FieldTouch nearby(self, FramePath path, double radius, bint so_far) noexcept

cdef BodyVelocity velocity_over(Follower body, double begin, double end) noexcept
cdef int fit(FieldSpeeds speeds, BodyVelocity now) noexcept
cdef int fit_direction(FieldSpeeds speeds, BodyVelocity now) noexcept

cdef int within(double value, double slack, double low, double high) noexcept
cdef int left_of_ray(BodyVelocity now, double x, double y, double tolerance) noexcept
cdef FramePath path_over(Encounter encounter, double begin, double end) noexcept
cdef double distance_to_edge(double x, double y, Edge e) noexcept
cdef double side_of(double x, double y, Edge e) noexcept
cdef bint cross(Edge e, Edge f) noexcept
cdef bint edge_passes(double x, double y, Edge e) noexcept
cdef double cut_beside(double before, double after, double bend) noexcept
