cdef Py_ssize_t _STRAIGHT
cdef Py_ssize_t _ACROSS
cdef Py_ssize_t _BUCKETS

cdef Py_ssize_t _estimate(Py_ssize_t cell, Py_ssize_t goal, Py_ssize_t columns) noexcept
