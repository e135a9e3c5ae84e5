// Curious: walks up to the gantry slowly, looks at it, loses interest after a
// while and continues. For some time after that it ignores the gantry.
//
// Figures: attention(Ms), how long the interest lasts (8000); sated(Ms), how
// long it does not come back (20000); approach_speed(F), the fraction of the
// top speed at which to walk up (0.4).

attention_span(Ms) :- attention(Ms).
attention_span(8000) :- not attention(_).
no_interest_for(Ms) :- sated(Ms).
no_interest_for(20000) :- not sated(_).
slowly(F) :- approach_speed(F).
slowly(0.4) :- not approach_speed(_).

bored :- looked_at(T) & now(N) & no_interest_for(Ms) & N - T < Ms.

+gantry_detected(_) : bound_for(S) & not errand(_) & not bored & slowly(F)
  <- stop_movement; .drop_all_desires; +errand(gantry); walk_speed(F); !set_out;
     !lose_interest(S).

+!set_out <- move_to_gantry.

+work_completed(_) : errand(gantry) <- face_gantry.

+!lose_interest(S) : attention_span(Ms)
  <- .wait(Ms); ?now(T); -+looked_at(T); stop_movement; !compose; !walk_to(S).

+!compose <- walk_speed(1); .abolish(errand(_)); .abolish(tried(_)).

// People are as interesting as the gantry, until the interest is lost.
+person_near(Who, _) : bound_for(S) & not errand(_) & not bored
  <- .drop_all_desires; +errand(person); !call_on(Who); !lose_interest(S).
+!call_on(Who) <- approach(Who).
-!call_on(_).

+work_completed(_) : errand(person).

{ include("patrol.asl") }
