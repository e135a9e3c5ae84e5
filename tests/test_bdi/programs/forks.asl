// Branches side by side, and what a failure in one does.
!start.
+!start <- !both; !either; !broken; !last(X); .print("done").
+!both <- (.print("l1"); .wait(10); .print("l2")) |&| (.print("r1"); .wait(20); .print("r2")); .print("both").
+!either <- !slow ||| !quick; .print("either").
+!slow <- .wait(50); .print("slow is not reached").
+!quick <- .wait(5); .print("quick").
+!broken <- !slow |&| !fails; .print("not reached").
+!fails <- .wait(5); .fail.
-!broken <- .print("broken recovers"); .wait(100).
+!last(X) <- X = 1 |&| Y = 2; .print("X and Y are each its branch's own").
