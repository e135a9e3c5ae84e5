// Helpful: makes room for the gantry. When it comes near, stops, waits a moment,
// and walks the ring in the other direction. A notice within five seconds of a
// turn is ignored, so that people do not turn on the spot.
//
// Figures: consideration(Ms), the moment (that of the rules, otherwise 1000);
// steadfast(Ms), how long no further turn is made (5000).

moment(Ms) :- consideration(Ms).
moment(Ms) :- not consideration(_) & usual_moment(Ms).
no_turn_for(Ms) :- steadfast(Ms).
no_turn_for(5000) :- not steadfast(_).

turned_lately :- turned_at(T) & now(N) & no_turn_for(Ms) & N - T < Ms.

@turn[atomic]
+gantry_detected(_) : not turned_lately & bound_for(S) & behind(S, Back) & moment(Ms)
  <- stop_movement; .drop_all_desires; .wait(Ms); !turn_round; !!walk_to(Back).

+!turn_round : reversed & now(T) <- -reversed; -+turned_at(T).
+!turn_round : now(T) <- +reversed; -+turned_at(T).

// Whoever comes in the way is let pass.
+in_the_way(Who, _) : bound_for(_) <- let_pass(Who).

// The rules give the moment as reaction(helpful, Ms).
usual_moment(Ms) :- reaction(helpful, Ms).
usual_moment(1000) :- not reaction(helpful, _).

{ include("patrol.asl") }
