from libc.math cimport cos, sin
from navigation.kernels.cubics cimport *
from navigation.kernels.encounter cimport Encounter
from navigation.kernels.laws cimport LawEvaluator

cdef int UNDECIDED
cdef double _SURE

cdef class IntervalTest:
    cdef int holds(self, Encounter encounter, double begin, double end) except -2

cdef class TooCloseTest(IntervalTest):
    cdef LawEvaluator law
    cdef double rounding
    cdef int short_of(self, Encounter encounter, double begin, double end) except -2

cdef Closest margin_over(
    LawEvaluator law, Encounter encounter, double begin, double end
) except *

cdef class MovingTest(IntervalTest):
    cdef double limit, reach

cdef class ApproachingTest(IntervalTest):
    pass

cdef class ApartTest(IntervalTest):
    cdef double metres

cdef class OverlappingTest(IntervalTest):
    cdef double along, across, other_along, other_across, depth, reach, other_reach

cdef double swing_of(Cubic turn, double half) noexcept

cdef class NotTest(IntervalTest):
    cdef IntervalTest other

cdef class BothTest(IntervalTest):
    cdef IntervalTest first
    cdef IntervalTest second

cdef class CustomTest(IntervalTest):
    cdef object condition

cdef class ChangeSearch:
    cdef IntervalTest judge
    cdef Encounter encounter
    cdef double end, resolution
    cdef bint held, over

cdef double next_change(
    IntervalTest judge, Encounter encounter, double end, double resolution, bint held
) except? -1
