cdef Py_ssize_t _ROOM

cdef class Heap:
    cdef list entries
    cdef readonly Py_ssize_t count
    cdef readonly double so_far
    cdef readonly Py_ssize_t here
    cdef readonly Py_ssize_t there
    cdef Py_ssize_t _room
    cdef double[::1] _bounds
    cdef double[::1] _lengths
    cdef Py_ssize_t[::1] _froms
    cdef Py_ssize_t[::1] _tos
    cdef int clear(self) except -1
    cdef int push(self, double bound, double so_far, Py_ssize_t here, Py_ssize_t there) except -1
    cdef int pop(self) except -1
    cdef int _rise(
        self, Py_ssize_t place, double bound, double so_far, Py_ssize_t here, Py_ssize_t there
    ) noexcept
    cdef bint _before(
        self, Py_ssize_t other, double bound, double so_far, Py_ssize_t here, Py_ssize_t there
    ) noexcept
    cdef int _move(self, Py_ssize_t place, Py_ssize_t to) noexcept
    cdef int _widen(self) except -1
