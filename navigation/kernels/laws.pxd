from navigation.kernels.encounter cimport Encounter
from navigation.kernels.odometer cimport Figure

cdef class Law:
    cdef bint of_speeds
    cdef bint steady
    cdef object source
    cdef Figure out
    cdef double distance(self, double human, double robot) except? -1
    cdef int require(self, Encounter encounter, double begin, double end) except? -1

cdef class LinearLaw(Law):
    cdef tuple speeds
    cdef double human
    cdef double robot
    cdef double stopping
    cdef double intrusion
    cdef double distance(self, double human, double robot) except? -1
    cdef int require(self, Encounter encounter, double begin, double end) except? -1

cdef class IntegralLaw(Law):
    cdef double t1
    cdef double t2
    cdef double stopping
    cdef double allowance
    cdef int require(self, Encounter encounter, double begin, double end) except? -1

cdef class ScaledLaw(Law):
    cdef Law law
    cdef double factor
    cdef double cap
    cdef double distance(self, double human, double robot) except? -1
    cdef int require(self, Encounter encounter, double begin, double end) except? -1

cdef class OwnLaw(Law):
    cdef bint of_motions
    cdef double distance(self, double human, double robot) except? -1
    cdef int require(self, Encounter encounter, double begin, double end) except? -1
