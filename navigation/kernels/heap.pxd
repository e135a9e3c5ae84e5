from navigation.kernels.numbers cimport *

cdef struct Entry:
    double bound, so_far
    Py_ssize_t here, there

ctypedef Entry* Entries

cdef inline Entries _entries(Numbers row) noexcept:
    return <Entry*> row.data.as_doubles

cdef Py_ssize_t _SOME, _WIDTH

cdef class Heap:
    cdef Numbers entries
    cdef readonly Py_ssize_t count
    cdef int clear(self) except -1
    cdef int push(self, Entry entry) except -1
    cdef Entry pop(self) noexcept
    cdef int _rise(self, Py_ssize_t place, Entry entry) noexcept

cdef bint _precedes(Entry entry, Entry other) noexcept
