from navigation.kernels.numbers cimport Doubles, Numbers
from navigation.kernels.throng cimport Throng

cdef Py_ssize_t _ROW
cdef Py_ssize_t _LEG
cdef Py_ssize_t _R
cdef double _BEFORE
cdef double _RAMP
cdef double _HAIR
cdef double _CLEAR
cdef Py_ssize_t _MORE
cdef double _HARDLY
cdef double _STANDS

cdef class Candidates:
    cdef readonly Numbers course
    cdef readonly double begin
    cdef readonly double now
    cdef readonly double speed
    cdef double leg_x
    cdef double leg_y
    cdef double max_speed
    cdef double acceleration
    cdef Numbers lead
    cdef Numbers lead_box
    cdef object slowed
    cdef readonly double whole
    cdef Numbers legs
    cdef Numbers losses
    cdef Numbers rows
    cdef Py_ssize_t count
    cdef Numbers tops
    cdef list[Py_ssize_t] near
    cdef Numbers stood
    cdef Numbers ends
    cdef readonly Py_ssize_t row
    cdef Py_ssize_t blocker
    cdef readonly double length
    cdef readonly double top_speed
    cdef readonly double delay
    cdef readonly double side
    cdef Numbers corners
    cdef Py_ssize_t many
    cdef Numbers aside
    cdef Numbers path
    cdef Numbers sketch
    cdef Numbers bounds
    cdef readonly Numbers table
    cdef readonly Numbers box
    cdef readonly double x
    cdef readonly double y
    cdef readonly double c
    cdef readonly double s
    cdef double off_x
    cdef double off_y
    cdef double by_x
    cdef double by_y
    cdef Py_ssize_t leg
    cpdef void clear(self) except *
    cpdef void add(
        self, double loss, double length, double top_speed, double delay
    ) except *
    cpdef void add_aside(
        self, double along, double side, double length, double top_speed
    ) except *
    cpdef void add_asides(
        self,
        Numbers sides,
        double widest,
        double usual,
        double extra,
        double length,
        double top_speed,
        double along,
    ) except *
    cpdef bint draw_along(self, double length, double top_speed, double delay) except -1
    cdef int come_to(self, double length) noexcept
    cpdef bint next_free(
        self, list[Py_ssize_t] near, Throng throng, double own
    ) except -1
    cdef bint next_course(self) except -1
    cdef bint _is_free(
        self, list[Py_ssize_t] near, Throng throng, double own
    ) except -1
    cdef int _look_at(
        self, list[Py_ssize_t] near, Throng throng, double own
    ) except -1
    cdef Py_ssize_t _cut(self) noexcept
    cdef Py_ssize_t _draw(self, Py_ssize_t count) except -1
    cdef bint _take(self, Py_ssize_t end) except -1
    cdef int _add(
        self,
        double loss,
        double length,
        double top_speed,
        double delay,
        double along,
        double side,
    ) except -1
    cdef bint _can_turn(self) noexcept
    cdef int _go_along(self) noexcept
    cdef int _go_aside(self, double along, double side) noexcept
    cdef double _longer(self, double along, double side) noexcept
    cdef int _shift(self, double along, double side) noexcept
    cdef int _seek(self, double length) noexcept
    cdef double _measure(self) noexcept

cdef bint _runs_into(Numbers corners, Py_ssize_t count, Numbers stood) noexcept
cdef bint _ends_at(Numbers corners, Py_ssize_t count, Numbers ends) noexcept
cdef Py_ssize_t _note(
    Doubles disc, Py_ssize_t o, double x, double y, double least
) noexcept
cdef double _apart(double ax, double ay, double bx, double by) noexcept
cpdef int bound(Numbers corners, Py_ssize_t count, Numbers more, Numbers box) noexcept
cdef int _widen(Doubles box, Doubles corner, Py_ssize_t count) noexcept
