from libc.math cimport cos, sin
from navigation.kernels.cubics cimport *
from navigation.kernels.encounter cimport Encounter
from navigation.kernels.laws cimport LawEvaluator, evaluator_of

cdef int UNDECIDED
cdef double _ROUNDING, _SURE

cdef class KernelCondition:
    cdef int decide(self, Encounter encounter, double begin, double end) except -2

cpdef KernelCondition in_kernel(object condition)

cdef class TooClose(KernelCondition):
    cdef readonly object law
    cdef LawEvaluator evaluator
    cdef int short_of(self, Encounter encounter, double begin, double end) except -2

cdef Closest margin_over(
    LawEvaluator law, Encounter encounter, double begin, double end
) except *

cdef class Moving(KernelCondition):
    cdef readonly double speed, reach

cdef class Approaching(KernelCondition):
    pass

cdef class Apart(KernelCondition):
    cdef readonly double metres

cdef class Overlapping(KernelCondition):
    cdef readonly object one, other
    cdef readonly double depth
    cdef double along, across, other_along, other_across, limit, reach, other_reach

cdef double swing_of(Cubic turn, double half) noexcept

cdef class Not(KernelCondition):
    cdef readonly object condition
    cdef KernelCondition inner

cdef class Both(KernelCondition):
    cdef readonly object first, second
    cdef KernelCondition one, other

cdef class CustomCondition(KernelCondition):
    cdef object condition

cdef class ChangeSearch:
    cdef KernelCondition condition
    cdef Encounter encounter
    cdef double end, resolution
    cdef bint holding, over

cdef double next_change(
    KernelCondition condition, Encounter encounter, double end, double resolution, bint holding
) except? -1
