// Visitor: goes to some stations, drawn at random, and leaves by the exit.
//
// Figures: calls(N), to how many stations (0); stay(Ms), how long at each (0). The exit is the
// trial's sink for the person, believed as exit(X, Y). Without one it walks from station to station.

stay_for(Ms) :- stay(Ms).
stay_for(0) :- not stay(_).
calls_left(N) :- to_call(N).
calls_left(N) :- not to_call(_) & calls(N).

some_station(S) :-
    .findall(N, station(N, X, Y) & not exit(X, Y), All) & .length(All, L) & L > 0 &
    .nth(math.floor(math.random(L)), All, S).

+human_start : exit(_, _) <- !onwards.
+work_completed(_) : bound_for(exit).
+work_completed(_) : exit(_, _) & stay_for(Ms) <- .abolish(tried(_)); .wait(Ms); !onwards.

+!onwards : calls_left(N) & N > 0 & some_station(S) <- -+to_call(N - 1); !walk_to(S).
+!onwards <- !walk_to(exit).

+!walk_to(exit) : exit(X, Y) <- -+bound_for(exit); move(X, Y, 0).

{ include("patrol.asl") }
