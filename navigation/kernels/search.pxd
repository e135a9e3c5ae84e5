from navigation.kernels.edges cimport Room
from navigation.kernels.heap cimport Heap

cdef double _SLACK
cdef Py_ssize_t _AT_ONCE
cdef double _BESIDE

cdef class Turns:
    cdef readonly double[:, ::1] columns
    cdef list[double] x
    cdef list[double] y
    cdef readonly Py_ssize_t count

cdef class Search:
    cdef Turns floor
    cdef list links
    cdef object expand
    cdef list parts
    cdef double start_x
    cdef double start_y
    cdef double goal_x
    cdef double goal_y
    cdef bint straight
    cdef Room room
    cdef set refused
    cdef bint alone
    cdef Py_ssize_t fixed
    cdef Py_ssize_t start
    cdef readonly Py_ssize_t goal
    cdef list[double] left
    cdef list[double] best
    cdef list[double] sure
    cdef Heap queue
    cdef dict lines
    cdef double x
    cdef double y
    cdef Py_ssize_t at
    cdef Turns turns
    cdef int _go(self, Py_ssize_t place) except -1
    cdef int _leave(self, Py_ssize_t here, double so_far) except -1
    cdef int _fan(
        self,
        Py_ssize_t here,
        double x,
        double y,
        Turns turns,
        Py_ssize_t at,
        Turns onto,
        Py_ssize_t first,
        double so_far,
    ) except -1
    cdef int _push(self, Py_ssize_t here, Py_ssize_t to, double so_far, double length) except -1
    cdef int _push_known(
        self, Py_ssize_t here, Py_ssize_t to, double so_far, double length
    ) except -1
    cdef double _bound(self, Py_ssize_t place) except -1.0
    cdef bint _clear(self, Py_ssize_t here, Py_ssize_t to, bint floor) except -1

cdef bint _grazes(
    double before_x, double before_y, double after_x, double after_y, double dx, double dy
) noexcept
