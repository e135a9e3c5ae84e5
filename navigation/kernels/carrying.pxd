from libc.math cimport cos, sin, sqrt
from navigation.kernels.cubics cimport *

cpdef Numbers carried(Numbers table, double ahead, double aside, double close)
cdef Py_ssize_t parts_of(PosePiece piece, double reach, double close) noexcept
cdef PosePiece _carried_part(
    PosePiece whole, double low, double begin, double end, double ahead, double aside
) noexcept
cdef Position _beside(double rotation, double ahead, double aside) noexcept
