from navigation.kernels.contacts cimport extent_from
from navigation.kernels.cubics cimport *
from navigation.kernels.encounter cimport Encounter, Gauge
from navigation.kernels.pieces cimport instant
from navigation.kernels.watch cimport KernelCondition, next_change

cdef double _AFTERWARDS

cdef class WatchRow:
    cdef double end, resolution, person_ends, machine_ends
    cdef list[Gauge] gauges
    cdef public KernelCondition condition
    cdef public double since, beyond
    cdef public bint idle, asks, holds
    cdef bint driven
    cdef readonly double due
    cdef readonly bint open
    cdef object person, machine
    cpdef search(self, object person, object machine, double now)
    cdef int update(self, double now) except -1
    cdef bint _is_near(self, double now) except -1

cpdef double horizon(double now, double one_ends, double other_ends, double end) noexcept
