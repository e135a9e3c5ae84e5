// Wary: stops when the gantry comes, and walks on when it stands or has gone.
//
// It looks twice a second at where the gantry is and how fast it moves.
// Figures: respect(Standing, Moving), how far from it is far enough, in metres (5, 9).

respect(5, 9).

distance(D) :- me(X, Y, _) & gantry(GX, GY, _) & D = math.sqrt((X - GX) ** 2 + (Y - GY) ** 2).
clear :- distance(D) & respect(Standing, Moving) & gantry(_, _, V)
  & (D > Moving | V < 0.1 & D > Standing).

+gantry_detected(_) : bound_for(S)
  <- stop_movement; .drop_all_desires; face_gantry; !go_on(S).

+!go_on(S) : clear <- !walk_to(S).
+!go_on(S) <- .wait(500); !go_on(S).

{ include("patrol.asl") }
