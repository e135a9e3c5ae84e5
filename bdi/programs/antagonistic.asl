// Antagonistic: when the gantry comes near, drops everything and walks up to it,
// then goes on to the station after the one where the walk was interrupted.

+gantry_detected(_) : bound_for(_)
  <- stop_movement; .drop_all_desires; -+errand(gantry); !set_out.

+!set_out <- move_to_gantry.

+work_completed(_) : errand(gantry) & bound_for(S) & ahead(S, Next)
  <- .abolish(errand(_)); !walk_to(Next).

{ include("patrol.asl") }
