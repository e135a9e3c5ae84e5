cdef Py_ssize_t _ROW
cdef Py_ssize_t _R
cdef double _BEFORE
cdef double _RAMP
cdef double _HAIR
cdef double _CLEAR
cdef double _HARDLY
cdef double _STANDS

cdef class Candidates:
    cdef list[double] course
    cdef double begin
    cdef double now
    cdef double speed
    cdef double vx
    cdef double vy
    cdef double max_speed
    cdef double acceleration
    cdef list[double] lead
    cdef list[double] lead_box
    cdef readonly double whole
    cdef list[double] rows
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
    cdef double x
    cdef double y
    cdef double c
    cdef double s
    cdef Py_ssize_t leg
    cpdef bint next_course(self) except -1
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
    cdef int _seek(self, double length) noexcept

cdef bint _runs_into(list[double] corners, list[double] stood) noexcept
cdef bint _ends_at(list[double] corners, list[double] ends) noexcept
cdef double _length(list[double] corners) noexcept
cdef list[double] _first(list[double] corners, double length)
cdef list[double] bounds(list[double] corners, list[double] more)
