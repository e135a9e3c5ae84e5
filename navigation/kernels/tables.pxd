from navigation.kernels.numbers cimport *

# Motions

cdef struct Cubic:
    double p, v, a, j

cdef struct PlanarPiece:
    double begin, end
    Cubic x, y

cdef struct PosePiece:
    double begin, end
    Cubic x, y, rotation

cdef struct Phase:
    double duration
    Cubic c

cdef struct PathLeg:
    double x, y, c, s, length, top, first

cdef struct SpeedLimits:
    double start, initial_speed, max_speed, acceleration

ctypedef PlanarPiece* PlanarPieces
ctypedef PosePiece* PosePieces
ctypedef Phase* Phases
ctypedef PathLeg* PathLegs

cdef inline PlanarPieces planar(Numbers table) noexcept:
    return <PlanarPiece*> table.data.as_doubles

cdef inline Py_ssize_t planar_count(Numbers table) noexcept:
    return len(table) // 10

cdef inline Numbers planar_room(Py_ssize_t count):
    return room(10 * count)

cdef inline int planar_cut(Numbers table, Py_ssize_t count) except -1:
    return cut(table, 10 * count)

cdef inline Py_ssize_t planar_at(Numbers table, double t) noexcept:
    return row_at(at(table), planar_count(table), 10, t)

cdef inline Numbers first_pieces(Numbers table, Py_ssize_t count):
    return part(table, 0, 10 * count)

cdef inline int planar_put(Numbers table, Numbers first) noexcept:
    return put(at(table), 0, at(first), 0, len(first))

cdef inline PathLegs planar_space(Numbers table, Py_ssize_t pieces, Py_ssize_t legs) except NULL:
    grow(table, 10 * pieces + 7 * legs)
    return <PathLeg*> (table.data.as_doubles + 10 * pieces)

cdef inline PosePieces poses(Numbers table) noexcept:
    return <PosePiece*> table.data.as_doubles

cdef inline Py_ssize_t pose_count(Numbers table) noexcept:
    return len(table) // 14

cdef inline Numbers pose_room(Py_ssize_t count):
    return room(14 * count)

cdef inline int pose_cut(Numbers table, Py_ssize_t count) except -1:
    return cut(table, 14 * count)

cdef inline Py_ssize_t pose_at(Numbers table, double t) noexcept:
    return row_at(at(table), pose_count(table), 14, t)

cdef inline bint is_pose_finite(Numbers table, Py_ssize_t k) noexcept:
    cdef double total = 0.0
    cdef Py_ssize_t i
    for i in range(14 * k, 14 * (k + 1)):
        total += table.data.as_doubles[i]
    return total - total == 0.0

cdef inline Phases phases(Numbers table) noexcept:
    return <Phase*> table.data.as_doubles

cdef inline Py_ssize_t phase_count(Numbers table) noexcept:
    return len(table) // 5

cdef inline Numbers phase_room(Py_ssize_t count):
    return room(5 * count)

cdef inline int phase_cut(Numbers table, Py_ssize_t count) except -1:
    return cut(table, 5 * count)

# Places, and what is at them

cdef struct Position:
    double x, y

cdef struct Placement:
    double x, y, rotation

cdef struct Circle:
    double x, y, radius

cdef struct Edge:
    double ax, ay, bx, by

cdef struct SweptSegment:
    double x, y, dx, dy, c, s, length

cdef struct Range:
    double low, high

cdef struct BoundingBox:
    double low_x, low_y, high_x, high_y

cdef struct GateLine:
    double ax, ay, bx, by, nx, ny

cdef struct CellWindow:
    Py_ssize_t column, row, columns, rows

ctypedef Position* Positions
ctypedef Placement* Placements
ctypedef Circle* Circles
ctypedef Edge* Edges
ctypedef BoundingBox* Boxes
ctypedef GateLine* GateLines

cdef inline Positions positions_of(Numbers row) noexcept:
    return <Position*> row.data.as_doubles

cdef inline Py_ssize_t position_count(Numbers row) noexcept:
    return len(row) // 2

cdef inline Numbers position_room(Py_ssize_t count):
    return room(2 * count)

cdef inline Numbers first_positions(Numbers row, Py_ssize_t count):
    return part(row, 0, 2 * count)

cdef inline int positions_put(Numbers row, Numbers first) noexcept:
    return put(at(row), 0, at(first), 0, len(first))

cdef inline Placements placements_of(Numbers row) noexcept:
    return <Placement*> row.data.as_doubles

cdef inline Py_ssize_t placement_count(Numbers row) noexcept:
    return len(row) // 3

cdef inline Numbers placement_room(Py_ssize_t count):
    return room(3 * count)

cdef inline int placement_grow(Numbers row, Py_ssize_t count) except -1:
    return grow(row, 3 * count)

cdef inline Circles circles_of(Numbers row) noexcept:
    return <Circle*> row.data.as_doubles

cdef inline Py_ssize_t circle_count(Numbers row) noexcept:
    return len(row) // 3

cdef inline Numbers circle_room(Py_ssize_t count):
    return room(3 * count)

cdef inline int circle_cut(Numbers row, Py_ssize_t count) except -1:
    return cut(row, 3 * count)

cdef inline Edges edges_of(Numbers row) noexcept:
    return <Edge*> row.data.as_doubles

cdef inline Py_ssize_t edge_count(Numbers row) noexcept:
    return len(row) // 4

cdef inline Numbers edge_room(Py_ssize_t count):
    return room(4 * count)

cdef inline Boxes boxes_of(Numbers row) noexcept:
    return <BoundingBox*> row.data.as_doubles

cdef inline Py_ssize_t box_count(Numbers row) noexcept:
    return len(row) // 4

cdef inline int box_cut(Numbers row, Py_ssize_t count) except -1:
    return cut(row, 4 * count)

cdef inline Numbers row_of_box(BoundingBox box):
    cdef Numbers row = room(4)
    boxes_of(row)[0] = box
    return row

cdef inline GateLines gates_of(Numbers row) noexcept:
    return <GateLine*> row.data.as_doubles

# Candidate walks of a person among others

cdef struct CoursePlace:
    double x, y, c, s
    Py_ssize_t leg

cdef struct CourseLeg:
    double length, c, s

cdef struct Bypass:
    double off_x, off_y, by_x, by_y, x, y
    Py_ssize_t leg

cdef struct CandidateWalk:
    double loss, length, top_speed, delay, along, side

cdef struct FrenetPlace:
    double along, left

cdef struct Meeting:
    Py_ssize_t person
    double t

cdef struct Leader:
    Py_ssize_t person
    double speed, walks_on

ctypedef CourseLeg* CourseLegs
ctypedef CandidateWalk* CandidateWalks

cdef inline CourseLegs course_legs(Numbers row) noexcept:
    return <CourseLeg*> row.data.as_doubles

cdef inline Numbers course_leg_room(Py_ssize_t count):
    return room(3 * count)

cdef inline CandidateWalks candidates_of(Numbers row) noexcept:
    return <CandidateWalk*> row.data.as_doubles

cdef inline Py_ssize_t candidate_count(Numbers row) noexcept:
    return len(row) // 6

cdef inline int candidates_grow(Numbers row, Py_ssize_t count) except -1:
    return grow(row, 6 * count)

# Bends of a floor, and the search for paths over them

cdef struct Wedge:
    double right_x, right_y, left_x, left_y

cdef struct Portal:
    double right_x, right_y, left_x, left_y, off, onto

cdef struct WaitingPortal:
    double portal
    Wedge wedge

cdef struct Bend:
    double x, y, before_x, before_y, after_x, after_y, reach

cdef struct Link:
    double to, length

cdef struct SearchEntry:
    double bound, so_far
    Py_ssize_t here, there

ctypedef Portal* Portals
ctypedef WaitingPortal* WaitingPortals
ctypedef Bend* Bends
ctypedef Link* Links
ctypedef SearchEntry* Entries

cdef inline Portals portals_of(Numbers row) noexcept:
    return <Portal*> row.data.as_doubles

cdef inline WaitingPortals waiting_of(Numbers row) noexcept:
    return <WaitingPortal*> row.data.as_doubles

cdef inline int waiting_grow(Numbers row, Py_ssize_t count) except -1:
    return grow(row, 5 * count)

cdef inline Bends bends_of(Numbers row) noexcept:
    return <Bend*> row.data.as_doubles

cdef inline Py_ssize_t bend_count(Numbers row) noexcept:
    return len(row) // 7

cdef inline int bend_cut(Numbers row, Py_ssize_t count) except -1:
    return cut(row, 7 * count)

cdef inline Links link_rows(Numbers row) noexcept:
    return <Link*> row.data.as_doubles

cdef inline Py_ssize_t link_count(Numbers row) noexcept:
    return len(row) // 2

cdef inline Numbers link_room(Py_ssize_t count):
    return room(2 * count)

cdef inline int link_cut(Numbers row, Py_ssize_t count) except -1:
    return cut(row, 2 * count)

cdef inline Entries entries_of(Numbers row) noexcept:
    return <SearchEntry*> row.data.as_doubles

cdef inline Py_ssize_t entry_count(Numbers row) noexcept:
    return len(row) // 4

cdef inline Numbers entry_room(Py_ssize_t count):
    return room(4 * count)

cdef inline int entries_grow(Numbers row, Py_ssize_t count) except -1:
    return grow(row, 4 * count)

# Distances and speeds over intervals

cdef struct TaylorModel:
    double value, slope, slack, curve

cdef struct Closest:
    double low, high, t

cdef struct NearestPoint:
    double x, y, away, distance

cdef struct RelativeMotion:
    double x, y, vx, vy, ax, ay, spin, half, bend, jolt, twist, swing

cdef struct FramePath:
    Edge tangent
    double bend

cdef struct FieldTouch:
    int state
    double cut

cdef struct SweepDrift:
    double ax, ay, bx, by, bend

cdef struct BodyVelocity:
    double ahead, aside, ahead_rate, aside_rate, turn, turn_slack, half, bend

cdef struct FieldSpeeds:
    double low, high, turn_low, turn_high, directed, ax, ay, bx, by, tolerance

cdef struct SeenPerson:
    double x, y, top_speed, fixed

cdef struct MovingPerson:
    double x, y, vx, vy

ctypedef FieldSpeeds* FieldRows
ctypedef SeenPerson* SeenPeople
ctypedef MovingPerson* MovingPeople

cdef inline FieldRows field_speeds(Numbers row) noexcept:
    return <FieldSpeeds*> row.data.as_doubles

cdef inline Py_ssize_t field_count(Numbers row) noexcept:
    return len(row) // 10

cdef inline SeenPeople seen_people(Numbers row) noexcept:
    return <SeenPerson*> row.data.as_doubles

cdef inline MovingPeople moving_people(Numbers row) noexcept:
    return <MovingPerson*> row.data.as_doubles

cdef inline Py_ssize_t person_count(Numbers row) noexcept:
    return len(row) // 4
