// Antagonistic: when the gantry comes near, drops all goals and walks up to it,
// then continues to the station after the one where the walk was interrupted.

+gantry_detected(_) : bound_for(_)
  <- stop_movement; .drop_all_desires; -+errand(gantry); !set_out.
+!set_out : moment(Ms) <- .wait(Ms); move_to_gantry.
+!set_out <- move_to_gantry.

+work_completed(_) : errand(gantry) & bound_for(S) & ahead(S, Next)
  <- .abolish(errand(_)); !walk_to(Next).

// Figure: consideration(Ms), how long it waits before it walks up to the gantry (that of the rules,
// which give it as reaction(antagonistic, Ms); otherwise it walks at once).

moment(Ms) :- consideration(Ms).
moment(Ms) :- not consideration(_) & reaction(antagonistic, Ms).

{ include("patrol.asl") }
