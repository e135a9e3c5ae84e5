// Waiting for times, events and conditions.
!start.
+!start
  <- .at("now +30", {+!alarm(1)}); .at("now +1 s", {+!alarm(2)});
     .wait(20); .print("20");
     .wait({+bell(X)}); .print("bell ", X);
     .wait(bell(Y) & Y > 5, 100, T1); .print("bell over 5 after ", T1);
     .wait(bell(Y2) & Y2 > 5); .print("already ", Y2);
     !patience; .wait(2000); .print("done").
+!alarm(1) <- .print("alarm 1"); +bell(3); .wait(25); -+bell(7).
+!alarm(N) <- .print("alarm ", N).
+!patience <- .wait({+never}, 15); .print("not reached").
-!patience[error(E)] <- .print("gave up: ", E); .wait({+never}, 5, T); .print("waited ", T).
