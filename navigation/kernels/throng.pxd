from navigation.kernels.numbers cimport Doubles, Numbers

cdef Py_ssize_t _R
cdef double _SLOW
cdef double _THERE

cdef class Throng:
    cdef readonly double gap
    cdef readonly list[Numbers] tables
    cdef readonly Numbers boxes
    cdef readonly Numbers radii
    cdef bytearray bound
    cdef Numbers onward
    cdef readonly double widest
    cdef double x
    cdef double y
    cdef double c
    cdef double s
    cpdef list[Py_ssize_t] near(self, Numbers box, double around, Py_ssize_t but=*)
    cdef list[Py_ssize_t] _resting(
        self, Py_ssize_t me, Numbers box, double around, double now
    )
    cpdef double between(self, Py_ssize_t i, Py_ssize_t k, double t) noexcept
    cdef bint heads(self, Py_ssize_t k, double t) noexcept
    cdef double cosine(self, Py_ssize_t k, double t, double c, double s) noexcept
    cdef int find(self, Py_ssize_t k, double t) noexcept
    cdef double rests(self, Py_ssize_t k) noexcept
    cdef int end(self, Py_ssize_t k) noexcept
