cdef double _at(list[double] table, Py_ssize_t o, double u) noexcept
