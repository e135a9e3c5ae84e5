// Scared: keeps away from the gantry. When it comes near, walks straight away
// from it, stays there until calm, and then continues to the station after the
// one where the walk was interrupted.
//
// Figures: retreat(Metres), how far (3); calm_after(Ms), how long to stay (3000).

retreat_by(D) :- retreat(D).
retreat_by(3) :- not retreat(_).
calming_time(Ms) :- calm_after(Ms).
calming_time(3000) :- not calm_after(_).

+gantry_detected(_) : bound_for(_) & not errand(_)
  <- stop_movement; .drop_all_desires; +errand(retreat); !set_out.

+!set_out : retreat_by(D) <- move_away(D).

+work_completed(_) : errand(retreat) & bound_for(S) & ahead(S, Next) & calming_time(Ms)
  <- .wait(Ms); .abolish(errand(_)); !walk_to(Next).

// Who comes in the way is a fright as well, but once: then it goes on to where it was going.
+in_the_way(Who, _) : bound_for(_) & not errand(_) & not knows(Who)
  <- .drop_all_desires; +knows(Who); +errand(shy); !keep_away(Who).
+!keep_away(Who) <- avoid(Who).
-!keep_away(_).

+work_completed(_) : errand(shy) & bound_for(S) & calming_time(Ms)
  <- .wait(Ms); .abolish(errand(_)); !walk_to(S).

{ include("patrol.asl") }
