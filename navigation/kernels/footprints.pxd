from libc.math cimport NAN, asin, atan2, ceil, copysign, cos, isnan, remainder, sin
from libc.math cimport M_PI as pi
from navigation.kernels.convex cimport meets_edge
from navigation.kernels.cubics cimport *
from navigation.kernels.edges cimport Room, back_through, touches
from navigation.kernels.fields cimport edge_passes

cdef double _NO_TURN

cdef class FootprintRoom:
    cdef public Room room, disc
    cdef Numbers corners
    cdef list[Numbers] parts
    cdef double slack, sag, step
    cdef bint sideways, alike
    cpdef bint fits(self, double x, double y, double rotation) except -1
    cpdef bint drive_free(
        self, double ax, double ay, double bx, double by, double rotation
    ) except -1
    cpdef Numbers drive_box(
        self, double ax, double ay, double bx, double by, double rotation
    )
    cpdef Numbers turn_box(self, double x, double y, double rotation)
    cpdef list turn_angles(self, double begin, double end)
    cdef Numbers _box(
        self,
        double x,
        double y,
        double c,
        double s,
        double turned,
        double length,
        double margin,
    )
    cpdef bint turn_free(self, double x, double y, double begin, double end) except -1
    cdef double _turned(self, double x, double y, double begin, double end) except? -1
    cpdef list between(self, tuple one, tuple to, double end)
    cdef bint _clear(self, Numbers polygon) except -1

cdef bint _meets_body(Numbers polygon, Numbers edges, double rounding) except -1
cdef bint _is_inside(Numbers edges, double x, double y) noexcept
