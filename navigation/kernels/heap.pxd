cpdef void heappush(list heap, tuple entry) except *
cpdef tuple heappop(list heap)
cdef int _rise(list heap, tuple entry, Py_ssize_t place) except -1
cdef bint _before(tuple one, tuple other) except -1
