from libc.math cimport cos, sin
from navigation.kernels.cubics cimport *
from navigation.kernels.encounter cimport Encounter
from navigation.kernels.fields cimport distance_to_edge, edge_passes, side_of

cdef double _RESOLUTION, _STEP, _NEARLY

cdef BoundingBox extent_from(Numbers table, double begin) noexcept
cpdef tuple places(Numbers table, double begin)

cdef class OutlineSearch:
    cdef Numbers edges, others, chords
    cdef bint outside
    cdef readonly double reach
    cpdef double first(self, Encounter encounter, double begin, double end) except? -1
    cpdef double parting(
        self, Encounter encounter, double begin, double end, double gap
    ) except? -1
    cpdef bint overlap(self, Encounter encounter, double t) except -1
    cdef double rate(self, Encounter encounter) noexcept
    cdef double apart(self, Encounter encounter, double t) noexcept
    cdef bint may_touch(self, Encounter encounter, double begin, double end) noexcept
    cdef SweepDrift sweep(self, Encounter encounter, double begin, double end) noexcept

cdef bint crosses(Edge e, Edge f) noexcept
cdef bint is_apart(Edge one, Edge other, Edge e, SweepDrift drift) noexcept
cdef bint separates(
    double x, double y, Edge one, Edge other, Edge e, SweepDrift drift
) noexcept
