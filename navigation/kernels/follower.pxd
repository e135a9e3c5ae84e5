from navigation.kernels.numbers cimport Numbers
from navigation.kernels.odometer cimport TaylorModel

cdef double _INFINITE
cdef Py_ssize_t _WIDTH

cdef class Follower:
    cdef Numbers table
    cdef Py_ssize_t rows
    cdef Py_ssize_t row
    cdef double since
    cdef double begin
    cdef double end
    cdef double x0
    cdef double x1
    cdef double x2
    cdef double x3
    cdef double y0
    cdef double y1
    cdef double y2
    cdef double y3
    cdef double r0
    cdef double r1
    cdef double r2
    cdef double r3
    cdef double low
    cdef double high
    cdef int seek(self, double t) except? -1
    cdef int go_on(self) except? -1
    cdef int enter(self, double t) noexcept
    cdef int pace(self, double middle, double half) noexcept
    cdef int speed(self, double begin, double end, TaylorModel figure) except? -1
