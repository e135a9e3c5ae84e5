from libc.math cimport atan2, copysign, sqrt
from navigation.kernels.cubics cimport *

cdef Py_ssize_t _WIDTH
cdef double _SHORTEST

cpdef tuple evaluate(Numbers table, Py_ssize_t row, double t, bint moving)
cdef PosePiece instant(Numbers table, double t) noexcept
cdef double _gap(PosePiece piece, PosePiece after) noexcept
cpdef Numbers rest(double begin, double end, double x, double y, double rotation)
cpdef Numbers merge_axes(list[Numbers] axes, double start)
cdef Cubic _axis_from(Numbers table, Py_ssize_t k, double u) noexcept
cpdef Numbers between(Numbers table, double begin, double end)
cdef PosePiece _rest_at(PosePiece piece, double begin, double end) noexcept

cdef class Pack:
    cdef readonly Py_ssize_t count
    cdef Numbers packed, last
