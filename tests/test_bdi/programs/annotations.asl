// Annotations: sources, subsets, tails.
door(1)[colour(red), seen(3), source(bob)].
door(2).
wide(D) :- door(D) & D > 1.

!start.
+!start
  <- ?door(1)[colour(C)]; .print("colour ", C);
     .findall(A, door(1)[A], As); .print(As);
     ?door(1)[source(S1)]; ?door(2)[source(S2)]; .print(S1, " ", S2);
     if (door(1)[colour(red), seen(3)]) { .print("both") };
     if (not door(1)[colour(blue)]) { .print("not blue") };
     p(1)[a|R] = p(1)[a, b, c]; .print(R);
     if (not p(1)[a, z] = p(1)[a, b]) { .print("z is missing") };
     ?wide(W)[source(S3)]; .print("wide ", W, " ", S3);
     +door(2)[seen(9)]; ?door(2)[seen(N)]; .print("seen ", N);
     -door(1)[seen(3)]; .findall(B, door(1)[B], Bs); .print(Bs);
     -door(1)[source(bob)]; if (not door(1)) { .print("door 1 is gone") };
     .print(q(1)[z, a, m, a]);
     !open(2)[hurry];
     G = shut(3); !G[softly];
     ?_[seen(M)]; .print("something seen ", M);
     .print("done").
+door(D)[seen(N)] <- .print("+door ", D, " seen ", N).
-door(D)[source(S)] <- .print("-door ", D, " ", S).
+!open(D)[hurry] <- .print("open ", D, " in a hurry").
+!open(D) <- .print("open ", D).
+!shut(D)[softly] <- .print("shut ", D, " softly").
