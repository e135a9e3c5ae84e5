// Inspector: walks the stations like everybody, but looks at each for a while.
//
// Figures: look(Ms), how long (3000).

look(3000).

@look[atomic]
+work_completed(_) : bound_for(S) & ahead(S, Next) & look(Ms)
  <- .print("looking at ", S); .wait(Ms); !!walk_to(Next).

{ include("patrol.asl") }
