// Changes of belief: order in the base, events, new focus.
b(1). b(2).
!start.
+!start
  <- +b(3); +>b(4); .findall(X, b(X), L); .print(L);
     -+b(9); .findall(Y, b(Y), L2); .print(L2);
     -b(Z); .print("took ", Z);
     ++c(1); .print("after ++"); --c(1); .print("after --");
     +d(_); if (d(anything)) { .print("d of anything") };
     -nothing(1); .abolish(b(_)); .count(b(_), N); .print(N, " left");
     .wait(1); .print("done").
+c(X) <- .print("+c ", X).
-c(X) <- .print("-c ", X).
-b(X) <- .print("-b ", X).
