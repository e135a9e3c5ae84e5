from navigation.kernels.cubics cimport *
from navigation.kernels.encounter cimport Encounter
from navigation.kernels.odometer cimport Odometer, enclosure_of, radius_of, speed_over

cdef class LawEvaluator:
    cdef bint of_speeds, steady
    cdef object source
    cdef double distance(self, double human, double robot) except? -1
    cdef TaylorModel require(self, Encounter encounter, double begin, double end) except *

cpdef LawEvaluator evaluator_of(object law)

cdef class LinearLaw(LawEvaluator):
    cdef double human, robot, stopping, intrusion

cdef class PathIntegralLaw(LawEvaluator):
    cdef double t1, t2, stopping, allowance

cdef class ScaledLaw(LawEvaluator):
    cdef LawEvaluator law
    cdef double factor, cap

cdef class PythonLaw(LawEvaluator):
    cdef bint of_motions
