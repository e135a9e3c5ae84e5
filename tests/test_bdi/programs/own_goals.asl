// Goals that are said to be achieved, to have failed, or are dropped.
!start.
+!start
  <- !!job(1); .wait(10); .succeed_goal(step(1)); .wait(10);
     !!job(2); .wait(10); .fail_goal(step(2)); .wait(10);
     !!job(3); .wait(10); .drop_intention(job(3)); .wait(10);
     !!job(4); .drop_event(job(4)); .drop_desire(job(4)); .wait(10);
     !!job(5); .wait(10); .suspend(job(5)); .wait(2000); .resume(job(5)); .wait(10);
     if (not .intend(job(_))) { .print("no jobs left") };
     .print("done").
+!job(N) <- .print("job ", N); !step(N); .print("job ", N, " goes on").
+!step(N) <- .wait(1000); .print("step ", N, " in full").
-!job(N) <- .print("job ", N, " failed").
