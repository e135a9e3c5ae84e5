// Plans that fail, and what their -!g plans are told.
!start.

+!start
  <- !no_plan; !no_context; !test; !comparison; !own_words; !action; !list; !index;
     !outer; !inner; !answer(X); .print("answer ", X); !again; .print("done").

+!no_plan <- !nothing(1).
-!no_plan[error(E), error_msg(M), code(C), code_line(L)]
  <- .print("no plan: ", E, " / ", M, " / ", C, " / line ", L).

+!no_context : 1 > 2 <- .print("never").
-!no_context[error(E)] <- .print("no context: ", E).

+!test <- ?unknown(3).
-!test[error(E), error_msg(M), code(C)] <- .print("test: ", E, " / ", M, " / ", C).

+!comparison <- 3 > 4.
-!comparison[error(E)] <- .print("comparison: ", E).

+!own_words <- .fail(reason(rain), error_msg("it rains")).
-!own_words[error(E), error_msg(M), reason(R)] <- .print("own words: ", E, " / ", M, " / ", R).

+!action <- jump(3).
-!action[error(E), code(C)] <- .print("action: ", E, " / ", C).

+!list <- .member(x, [a, b]).
-!list[error(E), code(C)] <- .print("list: ", E, " / ", C).

+!index <- .nth(5, [a], _).
-!index[error_msg(M)] <- .print("index: ", M).

// the failure goes down to the nearest goal with a plan for it
+!outer <- !middle; .print("not reached").
+!middle <- !deep; .print("not reached").
+!deep <- .fail.
-!outer <- .print("outer recovers").

// and the plan goes on after that goal
+!inner <- !leaf; .print("inner goes on").
+!leaf <- .fail.
-!leaf <- .print("leaf recovers").

// what a failure plan finds out counts
+!answer(_) <- .fail.
-!answer(42).

// a failure plan may try again
tries(0).
+!again : tries(N) & N >= 2 <- .print("third time").
+!again : tries(N) <- -+tries(N + 1); .fail.
-!again : tries(N) <- .print("again after ", N); !again.
