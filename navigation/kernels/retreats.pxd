from navigation.kernels.committed cimport Movers
from navigation.kernels.cubics cimport *
from navigation.kernels.discs cimport Swath, covers, distance
from navigation.kernels.edges cimport Legs, legs_of, touches
from navigation.kernels.walks cimport draw_walk

cdef double _HAIR, _JUST_NOW

cdef class Retreats:
    cdef Movers movers
    cdef Legs legs
    cdef SpeedLimits pace
    cdef double width, own
    cdef readonly tuple start
    cdef Numbers around, course, tops, lead, before, box, corners, places, stood
    cdef Py_ssize_t last, wide
    cdef list path
    cdef bint checked
    cdef readonly Py_ssize_t person, index, hit, tried
    cdef Swath sketch
    cpdef leave(self, Numbers course)
    cpdef look(self, list path, Numbers places)
    cpdef Swath next(self, Py_ssize_t limit, bytearray refusing)
    cpdef list retreat(self)
    cdef int _note_ends(self) except -1
    cdef Swath _come(self, Position end)
    cdef bint _meets_any(self) noexcept

cdef class RetreatSearch:
    cdef Movers movers
    cdef Py_ssize_t longest, most
    cdef public Py_ssize_t left
    cdef list[Retreats] asked
    cdef bytearray known, refusing
    cpdef refuse(self, bint everybody)
    cpdef bint clear(self, Py_ssize_t k, Swath draft, list course) except -1
    cpdef bint step(
        self, Retreats walks, list course, Numbers legs, Py_ssize_t depth
    ) except -1
    cdef bint _clear(
        self, Py_ssize_t mover, list course, Py_ssize_t depth, Py_ssize_t hit
    ) except -1
    cdef bint _is_enough(self, Py_ssize_t depth, Py_ssize_t moving) noexcept
    cdef Retreats _ask(self, Py_ssize_t k)
