// Goals in branches that others fail.
!start.
+!start
  <- !handled; .print("after handled"); !unhandled; .print("after unhandled");
     !below; .print("after below"); !either; .print("after either");
     !outside; .print("after outside"); !planless; .print("after planless").

+!handled
  <- !safe(1) |&| { .wait(50); .fail_goal(safe(1)); .wait(50); .print("other") }; .print("joined").
+!safe(N) <- .print("safe ", N); .wait(1000); .print("not here").
-!safe(N) <- .print("handled ", N).

+!unhandled <- !risky(1) |&| { .wait(50); .fail_goal(risky(1)); .print("last") }; .print("not here").
-!unhandled <- .print("unhandled failed").
+!risky(N) <- .print("risky ", N); .wait(1000); .print("not here").

+!below <- !deep |&| { .wait(50); .fail_goal(deep); .wait(50); .print("other") }; .print("joined").
+!deep <- !risky(2); .print("not here").
-!deep <- .print("deep failed"); .wait(100); .print("deep mended").

+!either <- !risky(3) ||| { .wait(50); .fail_goal(risky(3)); .print("first") }; .print("joined").

+!outside <- !!fails(safe(4)); !safe(4) |&| { .wait(100); .print("other") }; .print("joined").
+!fails(G) <- .wait(50); .fail_goal(G); .print("failed from outside").

+!planless <- !nobody |&| { .wait(50); .print("other") }; .print("joined").
-!nobody[error(E)] <- .print(E).
