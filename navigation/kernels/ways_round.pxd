from navigation.kernels.edges cimport Legs
from navigation.kernels.numbers cimport Numbers

cdef Py_ssize_t _CHUNK
cdef list[Py_ssize_t] _LEAPS
cdef double _SPARE

cdef class WaysRound:
    cdef double width
    cdef double around
    cdef Py_ssize_t most
    cdef object chunk
    cdef dict chunks
    cdef Py_ssize_t low_column
    cdef Py_ssize_t low_row
    cdef Py_ssize_t columns
    cdef Py_ssize_t rows
    cpdef void forget(self)
    cpdef list[double] path(
        self, double ax, double ay, double bx, double by, Numbers discs, Legs legs
    )
    cdef int _span(self, double ax, double ay, double bx, double by) noexcept
    cdef bytearray _blocked(self)
    cdef bytes _chunk(self, Py_ssize_t i, Py_ssize_t j)
    cdef list[double] _straightened(
        self,
        list[Py_ssize_t] cells,
        double x,
        double y,
        double bx,
        double by,
        Numbers discs,
        Legs legs,
    )

cdef Py_ssize_t _chunk_of(Py_ssize_t cell) noexcept
