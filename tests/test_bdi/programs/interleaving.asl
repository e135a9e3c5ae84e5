// Intentions take turns, one step each; a subgoal waits for its event.
!a. !b.
+!a <- .print("a1"); !sub; .print("a2"); .print("a3").
+!sub <- .print("sub").
+!b <- .print("b1"); !!c; .print("b2"); +seen(1); .print("b3"); .print("b4").
+!c <- .print("c1"); .print("c2").
+seen(N) <- .print("seen ", N); .print("seen still").
