from navigation.kernels.cubics cimport *

cpdef Numbers hull(Numbers points)
cdef Py_ssize_t _added(
    Numbers corners, Py_ssize_t total, Py_ssize_t first, Position point
) noexcept
cdef double turn_of(Position a, Position b, Position c) noexcept
cpdef bint is_apart(Numbers polygon, Numbers points) noexcept
cdef bint meets_edge(Numbers polygon, Edge e) noexcept
