from navigation.kernels.convex cimport meets_edge
from navigation.kernels.cubics cimport *

cdef double _WIDER, _LEVEL
cdef Py_ssize_t _LATELY, _LOOKED_AT

cdef class Grid:
    cdef double width, low_x, low_y
    cdef Py_ssize_t columns, rows
    cdef list[Numbers] cells
    cdef Numbers lately
    cpdef bint touched(self, double ax, double ay, double bx, double by, double radius)
    cpdef bint meets(self, Numbers polygon)
    cpdef bint inside(self, double x, double y)
    cdef Py_ssize_t _column(self, double x) noexcept
    cdef Py_ssize_t _row(self, double y) noexcept
    cdef Py_ssize_t _low_row(self, Edge e, double margin) noexcept
    cdef Py_ssize_t _high_row(self, Edge e, double margin) noexcept
    cdef int _remember(self, Edge edge) except -1
    cdef CellWindow _span(self, Py_ssize_t row, Edge e, double margin) noexcept

cdef class Room:
    cdef Grid floor
    cdef double radius
    cdef list[Numbers] bodies, gates
    cdef Numbers bounds, radii
    cpdef bint holds(self, double x, double y)
    cpdef bint clear(self, double ax, double ay, double bx, double by, bint floor)

cdef class Legs:
    cdef Grid walls
    cdef double radius
    cdef object ask
    cdef public Numbers bounds
    cdef bint meets_wall(self, double ax, double ay, double bx, double by) except -1
    cpdef bint free(self, double ax, double ay, double bx, double by) except -1
    cpdef Py_ssize_t farthest(self, double x, double y, list route) except -2
    cpdef Py_ssize_t farthest_round(
        self, double x, double y, list route, Numbers places, double width
    ) except -2
    cdef bint _keeps_off(
        self,
        double ax,
        double ay,
        double bx,
        double by,
        Numbers places,
        double width,
    ) except -1

cpdef Numbers legs_of(list course)
cpdef bint touches(
    Numbers edges, double ax, double ay, double bx, double by, double radius
) except -1
cpdef list come_into(Numbers bounds, list route, double radius)
cdef bint _comes_into(
    BoundingBox box, double ax, double ay, double bx, double by, double radius
) noexcept
cpdef bint back_through(
    Numbers line, double ax, double ay, double bx, double by
) except -1
cdef Py_ssize_t _first_near(Numbers edges, SweptSegment sweep, double radius) noexcept
cdef double _square(double px, double py, SweptSegment sweep) noexcept
cdef double _square_to(
    double px, double py, double qx, double qy, double x, double y
) noexcept
