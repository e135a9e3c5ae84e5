from libc.math cimport cos, sin
from navigation.kernels.cubics cimport *
from navigation.kernels.encounter cimport Closest, EncounterBounds
from navigation.kernels.gauge cimport Gauge
from navigation.kernels.laws cimport LawEvaluator
from navigation.kernels.numbers cimport *
from navigation.kernels.odometer cimport TaylorModel

cdef list[Gauge] _NO_GAUGES
cdef int UNDECIDED
cdef double _SURE

cdef class IntervalTest:
    cdef int holds(self, EncounterBounds encounter, double begin, double end) except -2

cdef class TooCloseTest(IntervalTest):
    cdef LawEvaluator law
    cdef double rounding
    cdef int holds(self, EncounterBounds encounter, double begin, double end) except -2
    cdef int short_of(self, EncounterBounds encounter, double begin, double end) except -2

cdef Closest margin_over(
    LawEvaluator law, EncounterBounds encounter, double begin, double end
) except *

cdef class MovingTest(IntervalTest):
    cdef double limit
    cdef int holds(self, EncounterBounds encounter, double begin, double end) except -2

cdef class ApproachingTest(IntervalTest):
    cdef int holds(self, EncounterBounds encounter, double begin, double end) except -2

cdef class ApartTest(IntervalTest):
    cdef double metres
    cdef int holds(self, EncounterBounds encounter, double begin, double end) except -2

cdef class OverlappingTest(IntervalTest):
    cdef double along
    cdef double across
    cdef double other_along
    cdef double other_across
    cdef double depth
    cdef double reach
    cdef double other_reach
    cdef int holds(self, EncounterBounds encounter, double begin, double end) except -2

cdef double swing_of(Cubic turn, double half) noexcept

cdef class NotTest(IntervalTest):
    cdef IntervalTest other
    cdef int holds(self, EncounterBounds encounter, double begin, double end) except -2

cdef class BothTest(IntervalTest):
    cdef IntervalTest first
    cdef IntervalTest second
    cdef int holds(self, EncounterBounds encounter, double begin, double end) except -2

cdef class CustomTest(IntervalTest):
    cdef object condition
    cdef int holds(self, EncounterBounds encounter, double begin, double end) except -2

cdef class ChangeSearch:
    cdef IntervalTest judge
    cdef EncounterBounds encounter
    cdef double end
    cdef double resolution
    cdef bint held
    cdef bint over

cdef double next_change(
    IntervalTest judge, EncounterBounds encounter, double end, double resolution, bint held
) except? -1
