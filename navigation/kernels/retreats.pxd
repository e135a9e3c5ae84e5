from navigation.kernels.committed cimport Movers
from navigation.kernels.cubics cimport *
from navigation.kernels.discs cimport Swath, distance
from navigation.kernels.edges cimport Legs, touches
from navigation.kernels.walks cimport draw_walk

cdef double _HAIR, _JUST_NOW

cdef class Retreats:
    cdef Movers movers
    cdef Legs legs
    cdef SpeedLimits pace
    cdef double width, own
    cdef Numbers course, tops, none, corners, places, stood
    cdef Py_ssize_t me, k, last
    cdef Swath sketch
    cdef public Swath taken
    cdef readonly Py_ssize_t hit, tried
    cdef int _note_ends(self) except -1
    cdef bint _come(self, Position end) except -1
    cdef bint _is_taken(self, double x, double y) noexcept
    cdef bint _meets_any(self) noexcept
