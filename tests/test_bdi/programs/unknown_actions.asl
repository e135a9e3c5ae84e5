// Internal actions that do not exist fail the plans that call them, and hold in no context.
r :- .norule(1).
!start.
+!start
  <- !body; !context; !query; B = { .print("begins"); .nobody(3) }; !carry(B);
     !length(5); !length([1, 2]); !length("abc"); .print("end").
+!body <- .print("begins"); .noaction(1); .print("not here").
-!body[error(E), code(C)] <- .print(E, " ", C).
+!context : .nocontext(1) <- .print("not here").
+!context <- .print("another plan").
+!query <- if (r) { .print("not here") } else { .print("no") }; .findall(X, floor.none(X), L); .print(L).
+!carry(B) <- B; .print("not here").
-!carry(_)[error(E)] <- .print(E).
+!length(X) <- .length(X, N); .print(N).
-!length(X)[error(E), error_msg(M)] <- .print(E, M).
