limit(3.5).
close(X) :- limit(L) & X <= L.
+limit(X) <- .print("limit is ", X).
