from libc.math cimport ceil, cos, sin
from navigation.kernels.convex cimport hull, is_apart
from navigation.kernels.cubics cimport *

cdef double _STEP, _GROUP, _SECTOR, _STRAIGHT, _RESTS

cpdef double end_of_part(Numbers table, double now, double seconds) noexcept
cpdef Numbers poses_along(Numbers table, double begin, double end)
cdef Py_ssize_t _samples(PosePiece piece, double seconds) noexcept
cpdef bint is_on_line(Numbers sampled) noexcept
cpdef list[Numbers] swept(Numbers sampled, Numbers corners, Numbers wider, bint turns)
cdef Numbers _placed(Placement pose, Numbers corners)
cdef int _add_sectors(
    list[Numbers] polygons,
    Numbers sampled,
    Py_ssize_t first,
    Py_ssize_t last,
    Numbers corners,
    Numbers wider,
) except -1
cdef bint _are_near(Placement a, Placement b) noexcept
cdef bint _share_line(Numbers sampled, Py_ssize_t first, Py_ssize_t last) noexcept
cdef bint _share_place(
    Numbers sampled, Py_ssize_t first, Py_ssize_t last, double limit
) noexcept

cdef class Polygons:
    cdef readonly list[Numbers] polygons
    cdef Numbers bounds
    cpdef tuple extent(self)
    cpdef bint meet(self, Polygons other)
