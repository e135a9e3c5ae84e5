from navigation.kernels.cubics cimport *

cdef Numbers _NODES, _WEIGHTS

cdef inline double radius_of(TaylorModel model, double half) noexcept:
    return (abs(model.slope) + abs(model.curve) * half / 2) * half + model.slack

cdef TaylorModel speed_along(PosePiece piece, double begin, double end) noexcept

cdef class PathLength:
    cdef Numbers table, stretches, before
    cdef double total, start, finish
    cpdef double reading(self, double t) except? -1
    cdef TaylorModel length_ahead(self, double begin, double end, double seconds) except *
    cdef TaylorModel speed_over(self, double begin, double end) noexcept

cpdef double length(Numbers stretches, Py_ssize_t k, double u) noexcept
