from navigation.kernels.numbers cimport Doubles, Numbers

cdef double _INFINITE
cdef Py_ssize_t _STRETCH
cdef Py_ssize_t _WIDTH
cdef Numbers _NODES
cdef Numbers _WEIGHTS

cdef class TaylorModel:
    cdef double value
    cdef double slope
    cdef double slack
    cdef double curve
    cdef int set(self, double value, double slope, double slack, double curve) except? -1

cdef Py_ssize_t row_at(Doubles row, Py_ssize_t rows, Py_ssize_t width, double t) noexcept

cdef int speed_along(Doubles c, Py_ssize_t row, double begin, double end, TaylorModel figure) except? -1

cdef class PathLength:
    cdef Numbers table
    cdef Numbers stretches
    cdef double total
    cdef double start
    cdef double finish
    cdef TaylorModel out
    cdef TaylorModel near
    cpdef double reading(self, double t) except? -1
    cdef int look_ahead(self, double begin, double end, double seconds) except? -1
    cdef int look(self, double begin, double end) except? -1

cpdef double length(Numbers table, Py_ssize_t row, double u) except? -1
