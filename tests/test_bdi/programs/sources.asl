// Beliefs without a source, which .assertz adds.
+b(X)[source(S)] <- .print("b ", X, " from ", S).
+b(X) <- .print("b ", X, " from nowhere").
-b(X)[source(S)] <- .print("no b ", X, " from ", S).
-b(X) <- .print("no b ", X).
!start.
+!start
  <- .assertz(b(1)); .wait(10); ?b(1)[|A]; .print(A); +b(1); .wait(10); ?b(1)[|B]; .print(B);
     -b(1); .wait(10); .assertz(b(2)); -b(2); if (b(2)) { .print("still there") };
     .wait(10); .abolish(b(2)); .wait(10); if (not b(2)) { .print("gone") };
     .assertz(b(3)[source(bob)]); .wait(10); .asserta(b(4)); .wait(10);
     .findall(S, b(_)[source(S)], L); .print(L);
     .assertz({ c(X) :- b(X) }); .asserta({ c(X) :- d(X) }); .list_rules.
