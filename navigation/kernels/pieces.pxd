cdef int _append_shifted(list[double] table, list[double] phases, Py_ssize_t row, double u, bint moving) except? -1
