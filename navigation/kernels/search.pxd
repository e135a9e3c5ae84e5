from navigation.kernels.cubics cimport *
from navigation.kernels.edges cimport Room
from navigation.kernels.network cimport Network, fits

cdef Py_ssize_t _SOME, _LONG
cdef double _BESIDE

cdef class Heap:
    cdef Numbers entries
    cdef readonly Py_ssize_t count
    cdef int clear(self) except -1
    cdef int push(self, SearchEntry entry) except -1
    cdef SearchEntry pop(self) noexcept
    cdef int _rise(self, Py_ssize_t place, SearchEntry entry) noexcept

cdef bint _precedes(SearchEntry entry, SearchEntry other) noexcept

cdef class Search:
    cdef Network network
    cdef Py_ssize_t fixed, start, goal
    cdef Heap queue
    cdef Numbers bends, best, sure, before
    cdef bint straight, alone
    cdef Room room
    cdef set refused
    cdef tuple _place(self, Py_ssize_t number)
    cdef int _lay_out(self, tuple start, tuple goal, list parts) except -1
    cdef int _leave(self, Py_ssize_t here, double so_far) except -1
    cdef int _fan(self, Py_ssize_t here, Py_ssize_t first, double so_far) except -1
    cdef int _push(self, Py_ssize_t here, Py_ssize_t to, double so_far, double length) except -1
    cdef int _push_known(
        self, Py_ssize_t here, Py_ssize_t to, double so_far, double length
    ) except -1
    cdef double _bound(self, Py_ssize_t place) noexcept
    cdef bint _clear(self, Py_ssize_t here, Py_ssize_t to, bint floor) except -1
