from libc.math cimport sqrt
from navigation.kernels.tables cimport *

cdef inline Cubic constant(double p) noexcept:
    return Cubic(p, 0.0, 0.0, 0.0)

cdef inline double value(Cubic c, double u) noexcept:
    return c.p + u * (c.v + u * (c.a + u * c.j))

cdef inline double gain(Cubic c, double u) noexcept:
    return u * (c.v + u * (c.a + u * c.j))

cdef inline double slope(Cubic c, double u) noexcept:
    return c.v + u * (2 * c.a + u * 3 * c.j)

cdef inline double second_slope(Cubic c, double u) noexcept:
    return 2 * c.a + 6 * u * c.j

cdef inline Cubic shift(Cubic c, double u) noexcept:
    return Cubic(value(c, u), slope(c, u), c.a + u * 3 * c.j, c.j)

cdef inline Cubic minus(Cubic c, Cubic d) noexcept:
    return Cubic(c.p - d.p, c.v - d.v, c.a - d.a, c.j - d.j)

cdef inline double norm(double x, double y) noexcept:
    return sqrt(x * x + y * y)

cdef inline Cubic along(double x, double c, Cubic way) noexcept:
    return Cubic(x + way.p * c, way.v * c, way.a * c, way.j * c)

cdef inline Position position_at(Numbers table, double t) noexcept:
    cdef PlanarPiece piece = planar(table)[planar_from(table, 0, t)]
    cdef double u = max(t - piece.begin, 0.0)
    return Position(value(piece.x, u), value(piece.y, u))

cdef inline PlanarPiece rest_piece(double t, double x, double y) noexcept:
    return PlanarPiece(t, INFINITY, constant(x), constant(y))

cdef inline double ahead_of(CoursePlace here, double x, double y) noexcept:
    return (x - here.x) * here.c + (y - here.y) * here.s

cdef inline double left_of(CoursePlace here, double x, double y) noexcept:
    return (y - here.y) * here.c - (x - here.x) * here.s

cdef inline SweptSegment sweep_along(Edge e) noexcept:
    cdef double dx = e.bx - e.ax
    cdef double dy = e.by - e.ay
    cdef double length = norm(dx, dy)
    if length > 0.0:
        return SweptSegment(e.ax, e.ay, dx, dy, dx / length, dy / length, length)
    return SweptSegment(e.ax, e.ay, dx, dy, 0.0, 0.0, length)

cdef inline double speed_at(Cubic x, Cubic y, double u) noexcept:
    return norm(slope(x, u), slope(y, u))

cdef inline bint is_straight(Cubic x, Cubic y) noexcept:
    return x.a == 0.0 and y.a == 0.0 and x.j == 0.0 and y.j == 0.0

cdef inline bint is_at_rest(Cubic x, Cubic y) noexcept:
    return is_straight(x, y) and x.v == 0.0 and y.v == 0.0

cdef inline double deviation(Cubic x, Cubic y, double half) noexcept:
    return half * half * (norm(x.a, y.a) + half * norm(x.j, y.j))

cdef inline double elapsed(double begin, double end, double t) noexcept:
    return min(max(t, begin), end) - begin

cdef inline double end_of(Numbers table) noexcept:
    return poses(table)[pose_count(table) - 1].end

cdef inline Py_ssize_t planar_from(Numbers table, Py_ssize_t k, double t) noexcept:
    while planar(table)[k].end <= t:
        k += 1
    return k

cdef inline Range range_of(Cubic c, double u) noexcept:
    cdef double last = value(c, u)
    cdef double low = min(c.p, last)
    cdef double high = max(c.p, last)
    cdef double third, one, two
    if c.j != 0.0 or (c.a != 0.0 and c.v * (c.v + 2 * c.a * u) < 0.0):
        third = u * c.v / 3
        one = c.p + third
        two = c.p + 2 * third + u * u * c.a / 3
        low = min(low, min(one, two))
        high = max(high, max(one, two))
    return Range(low, high)

cdef inline double nearest_on_line(Cubic x, Cubic y, double half) noexcept:
    cdef double square = x.v * x.v + y.v * y.v
    cdef double u
    if square == 0.0:
        return 0.0
    u = -(x.p * x.v + y.p * y.v) / square
    return -half if u < -half else half if u > half else u

cdef inline BoundingBox united(BoundingBox a, BoundingBox b) noexcept:
    return BoundingBox(
        min(a.low_x, b.low_x),
        min(a.low_y, b.low_y),
        max(a.high_x, b.high_x),
        max(a.high_y, b.high_y),
    )

cdef inline BoundingBox box_around(Numbers row, Py_ssize_t count) noexcept:
    cdef Position* position = positions_of(row)
    cdef BoundingBox box = BoundingBox(INFINITY, INFINITY, -INFINITY, -INFINITY)
    cdef Position p
    cdef Py_ssize_t k
    for k in range(count):
        p = position[k]
        box = united(box, BoundingBox(p.x, p.y, p.x, p.y))
    return box

cdef inline bint are_within(BoundingBox a, BoundingBox b, double least) noexcept:
    return (
        a.low_x - b.high_x < least
        and b.low_x - a.high_x < least
        and a.low_y - b.high_y < least
        and b.low_y - a.high_y < least
    )
