from cpython.array cimport array as Numbers, resize

ctypedef double* Doubles

cdef Numbers _NONE

cdef inline Doubles at(Numbers row) noexcept:
    return row.data.as_doubles

cdef inline int cut(Numbers row, Py_ssize_t count) except -1:
    return resize(row, count)

cdef inline int grow(Numbers row, Py_ssize_t count) except -1:
    return resize(row, count) if len(row) < count else 0

cpdef Numbers room(Py_ssize_t count)
cpdef Numbers numbers(values)
cdef Numbers part(Numbers row, Py_ssize_t begin, Py_ssize_t count)
cpdef Numbers flat(list places)
