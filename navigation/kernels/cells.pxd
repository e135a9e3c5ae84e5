cdef Py_ssize_t _SOME
cdef Py_ssize_t _FAR

cdef class Cells:
    cdef double width
    cdef object whole
    cdef object within
    cdef dict known
    cpdef bint has(self, double x, double y) except -1
