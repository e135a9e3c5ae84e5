from navigation.kernels.edges cimport Grid
from navigation.kernels.movers cimport Movers
from navigation.kernels.numbers cimport Doubles, Numbers

cdef Py_ssize_t _R
cdef double _HAIR
cdef double _JUST_NOW

cdef class Retreats:
    cdef Movers movers
    cdef Py_ssize_t me
    cdef Numbers legs
    cdef double width
    cdef double start
    cdef Numbers tops
    cdef double max_speed
    cdef double acceleration
    cdef double own
    cdef Grid walls
    cdef double radius
    cdef Numbers none
    cdef Numbers path
    cdef Numbers corners
    cdef Numbers sketch
    cdef Numbers bounds
    cdef Numbers places
    cdef Py_ssize_t k
    cdef Py_ssize_t last
    cdef Numbers stood
    cdef public Numbers table
    cdef public Numbers box
    cdef readonly Py_ssize_t hit
    cdef readonly Py_ssize_t tried
    cdef int _note_ends(self) except -1
    cdef bint _come(self, double x, double y) except -1
    cdef bint _is_taken(self, double x, double y) noexcept
    cdef bint _meets_any(self) noexcept
    cdef bint _meets(self, Py_ssize_t i) noexcept
    cdef int _set_out(self) except -1
