// Visitor: goes to random stations and leaves by the exit.
//
// Figures: calls(N), to how many stations (0); stay(Ms), how long at each (0). The exit is the
// trial's sink for the person, believed as exit(X, Y). Without one it walks from station to station.
//
// It goes to a station again only after it has set out for all of them. A violation ends the call
// that it was making: after the pause the visitor goes to the next station, or to the exit.

stay_for(Ms) :- stay(Ms).
stay_for(0) :- not stay(_).
calls_left(N) :- to_call(N).
calls_left(N) :- not to_call(_) & calls(N).

some_station(S) :-
    .findall(N, station(N, X, Y) & not exit(X, Y) & not called_on(N), All) &
    .length(All, L) & L > 0 & .nth(math.floor(math.random(L)), All, S).

+human_start : exit(_, _) <- !onwards.
+work_completed(_) : bound_for(exit).
+work_completed(_) : exit(_, _) & stay_for(Ms) <- .abolish(tried(_)); .wait(Ms); !onwards.

+!onwards : bound_for(exit) <- !walk_to(exit).
+!onwards : calls_left(N) & N > 0 & some_station(S)
  <- -+to_call(N - 1); +called_on(S); !walk_to(S).
+!onwards : calls_left(N) & N > 0 & called_on(_) <- .abolish(called_on(_)); !onwards.
+!onwards <- !walk_to(exit).

@violation_on_a_visit[atomic]
+gantry_disabled(_) : exit(_, _) & violation_pause(Ms)
  <- .drop_all_desires; teleport_safe; !compose; .wait(Ms); !!onwards.

@danger_on_a_visit[atomic]
+agv_danger(_) : exit(_, _) & agv_pause(Ms)
  <- .drop_all_desires; teleport_agv; !compose; .wait(Ms); !!onwards.

{ include("patrol.asl") }
