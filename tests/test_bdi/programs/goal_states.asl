// The states of goals that others have finish or fail.
!all.
+!all
  <- !!first; .wait(10); .fail_goal(first); .wait(10); !!second; .wait(10); .succeed_goal(second);
     .wait(10); !!third; .fail_goal(third); .wait(10);
     !!fourth; .wait(10); .suspend(fourth); .wait(10); .resume(fourth); .wait(50); .print(end).

+!first <- .wait(100).
-!first <- .print("first has failed").
+!second <- .wait(100).
+!third <- .wait(100).
+!fourth <- .wait(40).

^!first[state(S)] <- .print("first ", S).
^!second[state(S)] <- .print("second ", S).
^!third[state(S)] <- .print("third ", S).
^!fourth[state(S)] <- .print("fourth ", S).
