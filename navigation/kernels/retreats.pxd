from navigation.kernels.committed cimport Movers
from navigation.kernels.cubics cimport *
from navigation.kernels.discs cimport Swath, covers, distance
from navigation.kernels.edges cimport Legs, touches
from navigation.kernels.walks cimport draw_walk

cdef double _HAIR, _JUST_NOW

cdef class Retreats:
    cdef Movers movers
    cdef Legs legs
    cdef SpeedLimits pace
    cdef double width, own
    cdef Numbers course, tops, lead, before, box, corners, places, stood
    cdef Py_ssize_t person, index, last
    cdef Swath sketch
    cdef int _note_ends(self) except -1
    cdef Swath _come(self, Position end)
    cdef bint _meets_any(self) noexcept
