from libc.math cimport M_PI as pi, atan2, cos, isfinite, sin, sqrt, tan
from navigation.kernels.cubics cimport *

cdef double _NOWHERE, _DEVIATION, _HAIR, _STANDS, _STRAIGHT

cpdef bint is_place(object point) except -1
cdef bint _apart(tuple a, tuple b, double least) except -1
cdef bint _same_way(double wx, double wy, double vx, double vy) except -1
cdef bint _straight(tuple a, tuple b, tuple c) except -1
cpdef double corner_speed(tuple before, tuple corner, tuple after, double acceleration) except? -1
