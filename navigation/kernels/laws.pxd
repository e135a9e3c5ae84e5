from navigation.kernels.encounter cimport EncounterBounds
from navigation.kernels.odometer cimport TaylorModel

cdef class LawEvaluator:
    cdef bint of_speeds
    cdef bint steady
    cdef object source
    cdef TaylorModel out
    cdef double distance(self, double human, double robot) except? -1
    cdef int require(self, EncounterBounds encounter, double begin, double end) except? -1

cdef class LinearLaw(LawEvaluator):
    cdef tuple speeds
    cdef double human
    cdef double robot
    cdef double stopping
    cdef double intrusion
    cdef double distance(self, double human, double robot) except? -1
    cdef int require(self, EncounterBounds encounter, double begin, double end) except? -1

cdef class PathIntegralLaw(LawEvaluator):
    cdef double t1
    cdef double t2
    cdef double stopping
    cdef double allowance
    cdef int require(self, EncounterBounds encounter, double begin, double end) except? -1

cdef class ScaledLaw(LawEvaluator):
    cdef LawEvaluator law
    cdef double factor
    cdef double cap
    cdef double distance(self, double human, double robot) except? -1
    cdef int require(self, EncounterBounds encounter, double begin, double end) except? -1

cdef class PythonLaw(LawEvaluator):
    cdef bint of_motions
    cdef double distance(self, double human, double robot) except? -1
    cdef int require(self, EncounterBounds encounter, double begin, double end) except? -1
