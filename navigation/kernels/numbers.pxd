from libc.math cimport INFINITY
from cpython.array cimport array as Numbers, array as Wholes, resize
from libc.string cimport memcpy

ctypedef double* Doubles
ctypedef int* Ints

cdef Numbers _NONE

cdef inline Doubles at(Numbers row) noexcept:
    return row.data.as_doubles

cdef inline Ints ints(Wholes row) noexcept:
    return row.data.as_ints

cdef inline int cut(Numbers row, Py_ssize_t count) except -1:
    return resize(row, count)

cdef inline int grow(Numbers row, Py_ssize_t count) except -1:
    return resize(row, count) if len(row) < count else 0

cdef inline int put(
    Doubles row, Py_ssize_t o, Doubles other, Py_ssize_t p, Py_ssize_t count
) noexcept:
    memcpy(row + o, other + p, count * sizeof(double))
    return 0

cpdef Numbers room(Py_ssize_t count)
cdef Wholes whole(int value, Py_ssize_t count)
cpdef Numbers numbers(values)
cdef Numbers part(Numbers row, Py_ssize_t begin, Py_ssize_t count)
cpdef Numbers flat(list places)
cdef Py_ssize_t row_at(Doubles row, Py_ssize_t rows, Py_ssize_t width, double t) noexcept
