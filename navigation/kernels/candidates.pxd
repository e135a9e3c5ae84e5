from libc.math cimport sqrt
from navigation.kernels.cubics cimport *
from navigation.kernels.discs cimport DiscMotions, Swath, covers, distance
from navigation.kernels.walks cimport bend_speed, draw_walk

cdef double _BEFORE, _RAMP, _HAIR, _CLEAR, _STANDS, _NO_LENGTH
cdef Py_ssize_t _MORE

cdef class Course:
    cdef readonly Numbers corners
    cdef readonly double length
    cdef Py_ssize_t count
    cdef Numbers legs
    cdef CoursePlace come_to(self, double length) noexcept
    cdef CoursePlace seek(self, double length) noexcept
    cdef Bypass beside(self, double along, double side) noexcept
    cdef double longer(self, double along, double side) noexcept
    cdef Py_ssize_t corners_beside(self, double along, double side, Numbers corners) noexcept

cdef class Departure:
    cdef double begin, now, speed, leg_x, leg_y, max_speed, acceleration
    cdef bint follows
    cdef Numbers lead, box
    cdef bint can_turn(self, double dx, double dy) noexcept

cdef class Candidates:
    cdef readonly Course course
    cdef Departure state
    cdef object slowed
    cdef Numbers walks, stood, ends, tops, corners, path
    cdef Py_ssize_t count, row, blocker, corner_count
    cdef CandidateWalk looked_at
    cdef list[Py_ssize_t] near
    cdef Swath sketch
    cdef readonly Swath taken
    cpdef void clear(self) except *
    cpdef void add(self, double loss, double length, double top_speed, double delay) except *
    cdef void add_aside(
        self, double loss, double length, double top_speed, double along, double side
    ) except *
    cdef int _add(self, CandidateWalk walk) except -1
    cpdef Swath draw_along(self, double length, double top_speed, double delay)
    cpdef Swath next_free(self, list[Py_ssize_t] near, DiscMotions others, double own)
    cdef bint _next(self) except -1
    cdef int _come_to(self) noexcept
    cdef Py_ssize_t _free(
        self, list[Py_ssize_t] near, DiscMotions others, double own
    ) except -1
    cdef int _look_at(self, list[Py_ssize_t] near, DiscMotions others, double own) except -1
    cdef Py_ssize_t _cut(self) noexcept
    cdef Py_ssize_t _draw(self, Py_ssize_t count) except -1
    cdef Swath _take(self, Py_ssize_t pieces)

cdef bint _runs_into(Numbers path, Py_ssize_t count, Numbers stood) noexcept
