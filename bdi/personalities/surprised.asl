// Surprised: when the gantry comes near, stops, turns to it and watches for a
// while, then continues. Notices of the gantry meanwhile are ignored.
//
// Figure: astonishment(Ms), how long the watching lasts (3000).

watching_time(Ms) :- astonishment(Ms).
watching_time(3000) :- not astonishment(_).

+gantry_detected(_) : bound_for(S) & not errand(_) & watching_time(Ms)
  <- stop_movement; .drop_all_desires; +errand(watching); face_gantry;
     .wait(Ms); -errand(watching); !walk_to(S).

{ include("patrol.asl") }
