// What those have in common who walk with the leader of a group: wherever others would walk to a
// station, they walk with the leader. A trial puts these plans before those of their personality,
// and lets them believe
//     leader(Who)                    whom they walk with

ahead(together, together).
behind(together, together).

+human_start : leader(_) <- !walk_to(together).

// The leader may not be on the floor yet, or there is no path to them: then they try again.
+!walk_to(_) : leader(Who) <- -+bound_for(together); walk_with(Who).
-!walk_to(_) : leader(_) & .desire(rejoin).
-!walk_to(_) : leader(_) <- !!rejoin.

+path_blocked(_) : leader(_) & .desire(rejoin).
+path_blocked(_) : leader(_) <- !!rejoin.

+!rejoin <- .wait(1000); !!walk_to(together).

// Without their leader they leave as well, or walk on alone.
+has_left(Who, _) : leader(Who) & exit(_, _)
  <- .drop_all_desires; .abolish(leader(Who)); !walk_to(exit).
+has_left(Who, _) : leader(Who) & first(S)
  <- .drop_all_desires; .abolish(leader(Who)); .abolish(bound_for(_)); !walk_to(S).
