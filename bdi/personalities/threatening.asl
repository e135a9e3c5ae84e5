// Threatening: steps into the gantry's path, stays there for a while facing it,
// and continues.
//
// Figure: stand(Ms), how long to stand in the path (4000).

standing_time(Ms) :- stand(Ms).
standing_time(4000) :- not stand(_).

+gantry_detected(_) : bound_for(_) & not errand(_)
  <- stop_movement; .drop_all_desires; +errand(stand); !set_out.

+!set_out <- step_between.

+work_completed(_) : errand(stand) & bound_for(S) & standing_time(Ms)
  <- face_gantry; .wait(Ms); .abolish(errand(_)); !walk_to(S).

{ include("patrol.asl") }
