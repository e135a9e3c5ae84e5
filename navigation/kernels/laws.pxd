from navigation.kernels.cubics cimport *
from navigation.kernels.encounter cimport EncounterBounds
from navigation.kernels.odometer cimport PathLength, TaylorModel, radius_of

cdef class LawEvaluator:
    cdef bint of_speeds
    cdef bint steady
    cdef object source
    cdef double distance(self, double human, double robot) except? -1
    cdef TaylorModel require(self, EncounterBounds encounter, double begin, double end) except *

cdef class LinearLaw(LawEvaluator):
    cdef double human
    cdef double robot
    cdef double stopping
    cdef double intrusion
    cdef double distance(self, double human, double robot) except? -1
    cdef TaylorModel require(self, EncounterBounds encounter, double begin, double end) except *

cdef class PathIntegralLaw(LawEvaluator):
    cdef double t1
    cdef double t2
    cdef double stopping
    cdef double allowance
    cdef TaylorModel require(self, EncounterBounds encounter, double begin, double end) except *

cdef class ScaledLaw(LawEvaluator):
    cdef LawEvaluator law
    cdef double factor
    cdef double cap
    cdef double distance(self, double human, double robot) except? -1
    cdef TaylorModel require(self, EncounterBounds encounter, double begin, double end) except *

cdef class PythonLaw(LawEvaluator):
    cdef bint of_motions
    cdef double distance(self, double human, double robot) except? -1
    cdef TaylorModel require(self, EncounterBounds encounter, double begin, double end) except *
