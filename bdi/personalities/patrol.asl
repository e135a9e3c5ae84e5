// What all people have in common: they walk from station to station, in a ring.
//
// A personality includes this file at its end, so that its own plans come
// first. It believes at the start
//     station(Name, X, Y)            the stations, in the order of the patrol
//     pause_after_violation(Ms)      how long to stand after coming too close to
//                                    the gantry (8000 when it is not believed)
//     pause_after_agv(Ms)            the same for an AGV (8000)
//     patience(Ms), tries(N)         how long to wait where the path is blocked (2000),
//                                    and how often before the next station (3)
//     linger(Ms)                     how long to wait beside a station on which an AGV
//                                    stands before going to the next (8000)
// and it believes
//     bound_for(Station)             where it is going, or was before an errand
//     reversed                       it walks the ring in the other direction
//     errand(What)                   it is walking to something else
// A change of personality keeps the first two.

violation_pause(Ms) :- pause_after_violation(Ms).
violation_pause(8000) :- not pause_after_violation(_).
agv_pause(Ms) :- pause_after_agv(Ms).
agv_pause(8000) :- not pause_after_agv(_).
blocked_pause(Ms) :- patience(Ms).
blocked_pause(2000) :- not patience(_).
most_tries(N) :- tries(N).
most_tries(3) :- not tries(_).

lingering_time(Ms) :- linger(Ms).
lingering_time(8000) :- not linger(_).

// After a violation they start again at the first station, or go to the exit if they were leaving.
first(exit) :- bound_for(exit).
first(S) :- .findall(N, station(N, _, _), [S|_]).

away(S, Steps, T) :-
    .findall(N, station(N, _, _), Ring) & .length(Ring, L) &
    .nth(I, Ring, S) & .nth((I + Steps + L) mod L, Ring, T).

ahead(S, T) :- not reversed & away(S, 1, T).
ahead(S, T) :- reversed & away(S, -1, T).
behind(S, T) :- not reversed & away(S, -1, T).
behind(S, T) :- reversed & away(S, 1, T).

// milliseconds, to know how long ago something was
now(T) :- T = system.time.

+human_start : bound_for(S) <- !walk_to(S).
+human_start : first(S) <- !walk_to(S).

+!walk_to(S) : station(S, X, Y) <- -+bound_for(S); move(X, Y, 0).
+!walk_to(exit) : exit(X, Y) <- -+bound_for(exit); move(X, Y, 0).

+work_completed(_) : bound_for(S) & not errand(_) & ahead(S, Next)
  <- .abolish(tried(_)); !walk_to(Next).

// ---- too close: the person is teleported, waits, and starts again

@violation[atomic]
+gantry_disabled(_) : first(S) & violation_pause(Ms)
  <- .drop_all_desires; teleport_safe; !compose; -+bound_for(S);
     .wait(Ms); !!walk_to(S).

@danger[atomic]
+agv_danger(_) : first(S) & agv_pause(Ms)
  <- .drop_all_desires; teleport_agv; !compose; -+bound_for(S);
     .wait(Ms); !!walk_to(S).

+!compose <- .abolish(errand(_)); .abolish(tried(_)).

// ---- no path, on the ring or on an errand: the action fails, with a percept; wait, try again, after a few tries go elsewhere

-!walk_to(_).
-!set_out.

+path_blocked(_) : bound_for(S) <- !try_again(S).
+goal_blocked(_) : bound_for(S) <- !try_again(S).

+!try_again(_) : .desire(retry(_)).
+!try_again(S) : tried(N) & most_tries(Most) & N >= Most & ahead(S, Next)
  <- .abolish(tried(_)); .abolish(errand(_)); !retry(Next).
+!try_again(S) : tried(N) <- -+tried(N + 1); .abolish(errand(_)); !retry(S).
+!try_again(S) <- +tried(1); .abolish(errand(_)); !retry(S).

+!retry(S) : blocked_pause(Ms) <- .wait(Ms); !walk_to(S).

// ---- an AGV stands on the goal: the person waits beside it, and walks on when it has left;
// ---- after a while the person goes elsewhere

+goal_occupied(_) : .desire(linger_beside(_, _)).
+goal_occupied(_) : bound_for(S) & not errand(_) & lingering_time(Ms) <- !linger_beside(S, Ms).

+!linger_beside(_, Ms) <- .wait("+work_completed(_)", Ms).
-!linger_beside(S, _) : bound_for(S) & not errand(_) & ahead(S, Next) <- !walk_to(Next).
-!linger_beside(_, _).
