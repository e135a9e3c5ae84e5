// Goals with patterns: what makes them achieved, and what ends them.
tried(0). motive. reason.
!start.
+!start
  <- !reach(3); .print("reached"); !reach(3); .print("reached before");
     !build; .print("built"); !!end(motive, 30); !watch; .print("watched");
     !!end(hopeless, 30); !search; .print("no more").
-!start[error(E)] <- .print("start failed: ", E); !!end(reason, 30); !keep; .print("kept").

// What ends another goal comes from another intention.
+!end(hopeless, T) <- .wait(T); +hopeless.
+!end(motive, T) <- .wait(T); -motive.
+!end(reason, T) <- .wait(T); -reason.

{ begin bdg(reach(X)) }
+!reach(X) : tried(0) <- .print("first try for ", X); -+tried(1); .fail.
+!reach(X) <- .print("second try for ", X); +reach(X).
{ end }

{ begin bc(build) }
+!build : tried(1) <- .print("builds"); -+tried(2).
{ end }

{ begin rc(watch, motive) }
+!watch <- .print("watches"); .wait(1000); .print("not here").
{ end }

{ begin smc(search, hopeless) }
+!search <- .print("searches"); .wait(1000); .print("not here").
{ end }

{ begin omc(keep, hopeless, reason) }
+!keep <- .print("keeps"); .wait(1000); .print("not here").
{ end }
