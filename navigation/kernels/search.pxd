from libc.math cimport sqrt
from navigation.kernels.edges cimport Room
from navigation.kernels.heap cimport Entry, Heap
from navigation.kernels.network cimport Network, grazes
from navigation.kernels.numbers cimport *

cdef Py_ssize_t _SPARE
cdef double _SLACK
cdef Py_ssize_t _LONG
cdef Py_ssize_t _AT_ONCE
cdef double _BESIDE

cdef class Search:
    cdef Network network
    cdef Py_ssize_t fixed
    cdef Py_ssize_t start
    cdef Py_ssize_t goal
    cdef Heap queue
    cdef object bends
    cdef double[:, ::1] turns
    cdef double[::1] x
    cdef double[::1] y
    cdef double[::1] best
    cdef double[::1] sure
    cdef Py_ssize_t[::1] before
    cdef dict lines
    cdef bint straight
    cdef Room room
    cdef bint alone
    cdef set refused
    cdef tuple _place(self, Py_ssize_t number)
    cdef int _lay_out(self, tuple start, tuple goal, list parts) except -1
    cdef int _widen(self, Py_ssize_t places) except -1
    cdef int _leave(self, Py_ssize_t here, double so_far) except -1
    cdef int _fan(self, Py_ssize_t here, Py_ssize_t first, double so_far) except -1
    cdef int _push(self, Py_ssize_t here, Py_ssize_t to, double so_far, double length) except -1
    cdef int _push_known(
        self, Py_ssize_t here, Py_ssize_t to, double so_far, double length
    ) except -1
    cdef double _bound(self, Py_ssize_t place) noexcept
    cdef bint _clear(self, Py_ssize_t here, Py_ssize_t to, bint floor) except -1
    cdef bint _grazes(self, Py_ssize_t bend, double dx, double dy) noexcept
