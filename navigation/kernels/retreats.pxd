from navigation.kernels.edges cimport Grid

cdef Py_ssize_t _R
cdef double _HAIR
cdef double _JUST_NOW


cdef class Retreats:
    cdef list[double] legs
    cdef double width
    cdef double start
    cdef double top_speed
    cdef double max_speed
    cdef double acceleration
    cdef double own
    cdef Grid walls
    cdef double radius
    cdef list[list[double]] tables
    cdef list[double] boxes
    cdef list[double] radii
    cdef list[list[double]] floor_tables
    cdef list[double] floor_boxes
    cdef list[double] floor_radii
    cdef bytearray apart
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
