from navigation.kernels.throng cimport Throng

cdef Py_ssize_t _ROW
cdef Py_ssize_t _R
cdef double _BEFORE
cdef double _RAMP
cdef double _HAIR
cdef double _CLEAR
cdef double _HARDLY
cdef double _STANDS

cdef class Candidates:
    cdef readonly list[double] course
    cdef readonly double begin
    cdef readonly double now
    cdef readonly double speed
    cdef double vx
    cdef double vy
    cdef double max_speed
    cdef double acceleration
    cdef list[double] lead
    cdef list[double] lead_box
    cdef object slowed
    cdef readonly double whole
    cdef list[double] rows
    cdef list[Py_ssize_t] near
    cdef list[double] stood
    cdef list[double] ends
    cdef readonly Py_ssize_t row
    cdef double loss
    cdef Py_ssize_t blocker
    cdef readonly double length
    cdef readonly double top_speed
    cdef readonly double delay
    cdef readonly double side
    cdef readonly list[double] corners
    cdef readonly list[double] table
    cdef readonly list[double] box
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
    cpdef void add_asides(
        self,
        list[double] sides,
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
    cdef bint is_free_aside(
        self,
        double length,
        double top_speed,
        double along,
        double side,
        list[Py_ssize_t] near,
        Throng throng,
        double own,
    ) except -1
    cdef bint _is_free(
        self, list[Py_ssize_t] near, Throng throng, double own
    ) except -1
    cdef int _look_at(
        self, list[Py_ssize_t] near, Throng throng, double own
    ) except -1
    cdef bint _draw(self, list[double] corners) except -1
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
    cdef int _aside(self, double along, double side) except -1
    cdef double _longer(self, double along, double side) noexcept
    cdef int _shift(self, double along, double side) noexcept
    cdef int _seek(self, double length) noexcept

cdef bint _runs_into(list[double] corners, list[double] stood) noexcept
cdef bint _ends_at(list[double] corners, list[double] ends) noexcept
cdef double _apart(double ax, double ay, double bx, double by) noexcept
cdef double _length(list[double] corners) noexcept
cdef list[double] _first(list[double] corners, double length)
cdef list[double] bounds(list[double] corners, list[double] more)
