from navigation.kernels.edges cimport Grid
from navigation.kernels.movers cimport Movers

cdef Py_ssize_t _R
cdef double _HAIR
cdef double _JUST_NOW


cdef class Retreats:
    cdef Movers movers
    cdef Py_ssize_t me
    cdef list[double] legs
    cdef double width
    cdef double start
    cdef double top_speed
    cdef double max_speed
    cdef double acceleration
    cdef double own
    cdef Grid walls
    cdef double radius
    cdef list[double] none
    cdef list[double] path
    cdef list[double] places
    cdef Py_ssize_t k
    cdef Py_ssize_t last
    cdef list[double] stood
    cdef public list[double] table
    cdef public list[double] box
    cdef readonly Py_ssize_t hit
    cdef readonly Py_ssize_t tried
    cdef int _note_ends(self) except -1
    cdef bint _come(self, double x, double y) except -1
    cdef bint _is_taken(self, double x, double y) noexcept
    cdef bint _meets_any(self) noexcept
    cdef bint _meets(self, Py_ssize_t i) noexcept
cdef list[double] _flat(list points)
