from navigation.kernels.edges cimport Grid, back_through
from navigation.kernels.cubics cimport *

cdef double _SLACK, _WIDER, _ROUNDING

cdef class Network:
    cdef Py_ssize_t count
    cdef list links
    cdef Numbers bends, within, portals
    cdef list[Py_ssize_t] first_portal
    cdef list[Py_ssize_t] triangle
    cdef list[Py_ssize_t] first_bend
    cdef list[Py_ssize_t] order
    cdef Grid walls
    cdef double radius
    cdef list[Numbers] gates
    cdef Numbers waiting
    cdef Py_ssize_t depth
    cpdef Numbers links_of(self, Py_ssize_t bend)
    cdef Numbers _linked(self, Py_ssize_t here)
    cdef bint _clear(self, Py_ssize_t here, Py_ssize_t to) except -1
    cdef bint _allowed(self, Bend a, Bend b) except -1
    cdef list[Py_ssize_t] _seen(self, Py_ssize_t here)
    cdef int _expand(self, Py_ssize_t here, Wedge wedge, list[Py_ssize_t] found) except -1
    cdef int _take(
        self, Py_ssize_t triangle, Wedge wedge, Bend here, list[Py_ssize_t] found
    ) except -1
    cdef int _leave(self, Py_ssize_t triangle, Py_ssize_t came, Wedge wedge, Bend here) except -1
    cdef int _push(self, Py_ssize_t portal, Wedge wedge) except -1

cdef bint _leads(Numbers links, Py_ssize_t to) noexcept
cdef Wedge _from(Bend place, Portal portal) noexcept
cdef bint _faces(Wedge seen) noexcept
cdef bint _meet(Wedge wedge, Wedge other) noexcept
cdef Wedge _both(Wedge wedge, Wedge other) noexcept
cdef bint _has(Wedge wedge, double dx, double dy) noexcept
cdef double _slack(double dx, double dy, double px, double py) noexcept
cdef bint fits(Bend bend, double dx, double dy) noexcept
