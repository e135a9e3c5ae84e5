// Goals that are suspended before a plan for them is chosen, while they wait, and by themselves.
^!G[state(S)[reason(R)]] : not G = start <- .print("   ", G, " ", S, " ", R).
!start.
+!start
  <- !!early(1); .suspend(early(1)); .findall(X, .desire(early(X)), D); .print("desired ", D);
     .findall(X, .intend(early(X)), I); .print("intended ", I);
     .wait(20); .resume(early(1)); .wait(20);
     !!later; .wait(10); .suspend(later); .wait(100); .suspended(later, R); .print("because ", R);
     .resume(later); .wait(20);
     !!itself; .wait(10); .resume(itself); .wait(10);
     !!dropped; .suspend(dropped); .drop_desire(dropped); .resume(dropped); .wait(20); .print(end).
+!early(X) <- .print("early ", X).
+!later <- !waits.
+!waits <- .wait(50); .print("later").
+!itself <- .print("stops itself"); .suspend; .print("goes on"); act; .print("has acted").
+!dropped <- .print("not here").
