from libc.math cimport floor
from navigation.kernels.cubics cimport *
from navigation.kernels.discs cimport covers
from navigation.kernels.edges cimport Legs, touches

cdef Py_ssize_t _STRAIGHT, _ACROSS, _BUCKETS, _SOME, _FAR, _CHUNK
cdef list[Py_ssize_t] _LEAPS
cdef double _SPARE

cdef class Cells:
    cdef double width
    cdef object whole, within
    cdef dict cached
    cpdef bint has(self, double x, double y) except -1

cdef class WaysRound:
    cdef double width, around
    cdef object chunk
    cdef dict chunks
    cdef Py_ssize_t limit
    cdef CellWindow _span(self, double ax, double ay, double bx, double by) noexcept
    cdef bytearray _blocked(self, CellWindow window)
    cdef bytes _chunk(self, Py_ssize_t i, Py_ssize_t j)

cdef list _straightened(Numbers places, Numbers discs, Legs legs)
cdef Numbers _wider(Numbers discs)
cdef Py_ssize_t _chunk_of(Py_ssize_t cell) noexcept
cpdef int block_discs(
    bytearray blocked, Py_ssize_t columns, tuple corner, double width, Numbers discs
) except -1
cpdef Numbers middles(Numbers discs)
cdef Py_ssize_t _estimate(Py_ssize_t cell, Py_ssize_t goal, Py_ssize_t columns) noexcept
cpdef list grid_path(
    bytearray blocked, Py_ssize_t columns, Py_ssize_t start, Py_ssize_t goal
)
