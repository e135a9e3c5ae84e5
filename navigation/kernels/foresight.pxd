from navigation.kernels.candidates cimport Candidates
from navigation.kernels.edges cimport Legs
from navigation.kernels.grid cimport Cells
from navigation.kernels.numbers cimport Doubles, Numbers
from navigation.kernels.throng cimport Throng

cdef double _STANDS
cdef double _HAIR

cdef class ChoiceParameters:
    cdef readonly double stride
    cdef readonly double farthest
    cdef readonly double looks_around
    cdef readonly Numbers detours
    cdef readonly Numbers widths
    cdef readonly double widest
    cdef readonly Numbers paces
    cdef readonly Numbers delays
    cdef readonly Numbers parts
    cdef readonly double shortest
    cdef readonly double phantom
    cdef readonly Numbers files
    cdef readonly double faster
    cdef readonly double beside_after
    cdef readonly double past
    cdef readonly double other_side
    cdef readonly double brush
    cdef readonly double alike
    cdef readonly double closes_in
    cdef readonly double sees
    cdef readonly double least_speed
    cdef readonly double same_way
    cdef readonly double closes_up

cdef class TrajectoryChoice:
    cdef ChoiceParameters given
    cdef Throng throng
    cdef Py_ssize_t me
    cdef double radius
    cdef double own
    cdef double comfort
    cdef double time_gap
    cdef double foresight
    cdef double usual
    cdef Cells narrow
    cdef Cells narrow_outside
    cdef Legs legs
    cdef Candidates walks
    cdef readonly bint inside
    cdef double top_speed
    cdef readonly bint wishes
    cdef readonly double reach
    cdef readonly double stop
    cdef bytearray known
    cdef Numbers table
    cdef Numbers box
    cdef readonly Numbers seen
    cdef readonly list[Py_ssize_t] near
    cdef readonly Py_ssize_t hit
    cdef readonly double hit_at
    cdef double met_at
    cdef Numbers when
    cdef Py_ssize_t ahead
    cdef double ahead_speed
    cdef double ahead_walks_on
    cdef double beside
    cpdef bint wish(self) except -1
    cpdef bint first_free(self) except -1
    cpdef double stop_beyond(self, double length) except -1.0
    cdef double stop_before(self, double length) except -1.0
    cdef bint is_narrow(self, double length) except -1
    cdef bint _is_narrow_at(self, double x, double y) except -1
    cpdef Py_ssize_t look(self) except -2
    cdef int _see(self, double around) except -1
    cdef Py_ssize_t _first_met(self, double own) except -2
    cdef int _follow(self) except -1
    cdef Py_ssize_t _followed(
        self, double x, double y, double c, double s, list[Py_ssize_t] slow
    ) except -2
    cdef double _speed_behind(
        self, Py_ssize_t k, double x, double y, double c, double s
    ) noexcept
    cdef double _speed_beside(self, double side) except? -1.0
    cdef bint _keep_distance(self, Py_ssize_t near, double near_at) except -1
    cdef int _propose_slower_later_shorter(
        self, double hit_at, bint at_rest, bint follows
    ) except -1
    cdef bint _may_go_in(self, double length, bint follows) except -1
    cdef bint _is_opposed(self, double length) except -1
    cdef int _propose_files(self) except -1
    cdef int _propose_past(self, Py_ssize_t k, double t, bint opposed) except -1
    cdef int _propose_detours(self, Py_ssize_t k, double t) except -1
    cdef double _come_beside(self, Py_ssize_t k, double t) except? -1.0
    cdef bint _next_free(self) except -1
    cpdef bint aside(self, double along, double side, list[Py_ssize_t] near) except -1
    cdef bint _has_room(self) except -1
