from libc.math cimport cos, sin
from navigation.kernels.braking cimport Stops
from navigation.kernels.cubics cimport *
from navigation.kernels.encounter cimport Encounter, Gauge, nearest_surface
from navigation.kernels.laws cimport LawEvaluator
from navigation.kernels.odometer cimport radius_of, speed_over
from navigation.kernels.pieces cimport instant, rest
from navigation.kernels.watch cimport ChangeSearch, TooClose

cdef class Towards(LawEvaluator):
    cdef LawEvaluator law
    cdef double speed, since, fixed, margin

cdef class MotionSpan:
    cdef readonly Numbers table
    cdef double begin, end, fastest, x, y, last_x, last_y, last_turn, last_speed

cdef class Lookout:
    cdef LawEvaluator law
    cdef double margin, resolution, around
    cdef list[Gauge] gauges
    cpdef tuple safe_until(
        self, Numbers motion, Stops stops, list[double] people, double now, double least
    )
    cpdef double lacking(
        self, Numbers motion, Stops stops, list[double] people, double now, double least
    ) except? -1
    cdef double required(self, SeenPerson person, double speed) except? -1
    cdef bint hinders(self, SeenPerson person, MotionSpan on, double since) except -1
    cdef bint in_reach(self, SeenPerson person, MotionSpan on, double since) except -1
    cdef double spare(self, SeenPerson person, MotionSpan on, double since) except? -1

cpdef double nearest_on(
    Numbers motion,
    list[double] people,
    double now,
    double begin,
    double end,
    double step,
    double horizon,
) except? -1
cpdef int most_remote(
    list[double] places,
    list[double] people,
    list[double] glances,
    double horizon,
    double top,
    double lag,
    double enough,
) except -1
