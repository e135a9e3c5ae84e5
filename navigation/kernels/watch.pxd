from navigation.kernels.encounter cimport Encounter
from navigation.kernels.follower cimport Follower
from navigation.kernels.gauge cimport Gauge
from navigation.kernels.laws cimport Law

cdef double _INFINITE
cdef list[Gauge] _NO_GAUGES
cdef int UNDECIDED
cdef double _SURE

cdef class Judge:
    cdef int holds(self, Encounter encounter, double begin, double end) except -2

cdef class TooClose(Judge):
    cdef Law law
    cdef double rounding
    cdef int holds(self, Encounter encounter, double begin, double end) except -2
    cdef int short_of(self, Encounter encounter, double begin, double end) except -2

cdef int margin_bounds(Law law, Encounter encounter, double begin, double end) except? -1

cdef class Faster(Judge):
    cdef double limit
    cdef int holds(self, Encounter encounter, double begin, double end) except -2

cdef class Approaching(Judge):
    cdef int holds(self, Encounter encounter, double begin, double end) except -2

cdef class Apart(Judge):
    cdef double metres
    cdef int holds(self, Encounter encounter, double begin, double end) except -2

cdef class Overlapping(Judge):
    cdef double along
    cdef double across
    cdef double other_along
    cdef double other_across
    cdef double depth
    cdef double reach
    cdef double other_reach
    cdef int holds(self, Encounter encounter, double begin, double end) except -2

cdef double turned(Follower body, double u, double half) noexcept

cdef class Not(Judge):
    cdef Judge other
    cdef int holds(self, Encounter encounter, double begin, double end) except -2

cdef class Both(Judge):
    cdef Judge first
    cdef Judge second
    cdef int holds(self, Encounter encounter, double begin, double end) except -2

cdef class OwnJudge(Judge):
    cdef object condition
    cdef int holds(self, Encounter encounter, double begin, double end) except -2

cdef class Watch:
    cdef Judge judge
    cdef Encounter encounter
    cdef double end
    cdef double resolution
    cdef bint held
    cdef bint over

cdef double next_change(
    Judge judge, Encounter encounter, double end, double resolution, bint held
) except? -1

cdef int margin_over(Law law, Encounter encounter, double begin, double end) except? -1
