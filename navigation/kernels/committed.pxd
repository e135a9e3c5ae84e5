from navigation.kernels.cubics cimport *
from navigation.kernels.discs cimport DiscMotions, Swath, within_bounds

cdef double _SLOW, _AROUND, _THERE

cdef class CommittedMotions(DiscMotions):
    cdef bytearray bound
    cdef Numbers onward
    cdef readonly double widest
    cpdef list[Py_ssize_t] near(self, Numbers box, double around, Py_ssize_t but=*)
    cdef double rests(self, Py_ssize_t k) noexcept
    cdef PlanarPiece end(self, Py_ssize_t k) noexcept
    cdef Position place(self, Py_ssize_t k, double t) noexcept
    cdef Position heading(self, Py_ssize_t k, double t) noexcept
    cdef double cosine(self, Py_ssize_t k, double t, double c, double s) noexcept
    cpdef double between(self, Py_ssize_t i, Py_ssize_t k, double t) noexcept
    cdef list[Py_ssize_t] _resting(self, Py_ssize_t person, Numbers box, double around, double now)

cdef class Movers(DiscMotions):
    cdef readonly CommittedMotions floor
    cdef readonly double now
    cdef readonly list[Py_ssize_t] indices
    cdef bytearray among
    cdef list[Py_ssize_t] near
    cdef BoundingBox seen
    cpdef move(self, Py_ssize_t k, Swath swath)
    cpdef keep(self, Py_ssize_t count)
    cdef double own(self, Py_ssize_t k) noexcept
    cpdef bint meet(self, Py_ssize_t k, Swath swath) noexcept
    cpdef bint meets(self, Py_ssize_t i, Swath swath, double own) noexcept
    cpdef Py_ssize_t first_hit(self, Py_ssize_t i) except -2
    cpdef Py_ssize_t first_other(self, Py_ssize_t k, Swath swath) except -2
