from navigation.kernels.cubics cimport *

cdef Numbers _NODES, _WEIGHTS

cdef inline double radius_of(TaylorModel model, double half) noexcept:
    return (abs(model.slope) + abs(model.curve) * half / 2) * half + model.slack

cdef TaylorModel speed_along(PosePiece piece, double begin, double end) noexcept

cdef object enclosure_of(TaylorModel model)

cdef class Odometer:
    cdef object motion
    cdef Numbers table, stretches, before
    cdef double total
    cpdef double reading(self, double t) except? -1
    cdef TaylorModel length_ahead(self, double begin, double end, double seconds) except *

cdef TaylorModel speed_over(Numbers table, double begin, double end) noexcept
cdef tuple smooth_stretches(object motion)
cpdef double length(Numbers stretches, Py_ssize_t k, double u) noexcept
