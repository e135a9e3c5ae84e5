from libc.math cimport ceil
from navigation.kernels.candidates cimport Candidates, Departure
from navigation.kernels.committed cimport CommittedMotions
from navigation.kernels.cubics cimport *
from navigation.kernels.discs cimport Swath, distance_travelled
from navigation.kernels.edges cimport Legs
from navigation.kernels.following cimport CarFollowing, ChoiceParameters, Passer
from navigation.kernels.grid cimport Cells

cdef double _STANDS, _HAIR, _HARDLY, _LATER, _BEYOND

cdef class TrajectoryChoice:
    cdef ChoiceParameters parameters
    cdef Candidates walks
    cdef Departure state
    cdef CommittedMotions motions
    cdef Passer walker
    cdef CarFollowing following
    cdef Cells narrow
    cdef Legs legs
    cdef readonly bint inside
    cdef readonly double reach, stop
    cdef double own
    cdef bytearray checked
    cdef Swath wished
    cdef readonly Numbers seen
    cdef readonly list[Py_ssize_t] near
    cdef list[Py_ssize_t] all_near, without
    cdef Py_ssize_t excluded
    cdef Meeting hit
    cdef Leader ahead
    cpdef double stop_beyond(self, double length) except -1
    cdef double stop_before(self, double length) except -1
    cdef bint is_narrow(self, double length) except -1
    cdef int _see(self, double around) except -1
    cdef Meeting _first_met(self, double own, double until) except *
    cdef Swath _keep_distance(self, Meeting near)
    cdef int _propose_slower_later_shorter(
        self, double hit_at, bint at_rest, bint follows
    ) except -1
    cdef bint _may_go_in(self, double length, bint follows) except -1
    cdef bint _is_opposed(self, double length) except -1
    cdef int _propose_files(self) except -1
    cdef int _propose_past(self, Meeting other, bint opposed) except -1
    cdef int _add_asides(
        self, Numbers sides, double length, double top_speed, double along
    ) except -1
    cdef int _add_aside(
        self, double side, double length, double top_speed, double along
    ) except -1
    cdef FrenetPlace _level_with(self, Meeting other) noexcept
    cdef Swath _next_free(self)
    cdef bint _has_room(self) except -1
