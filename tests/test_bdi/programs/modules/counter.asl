level(1).
@raising +!raise(N) : level(L) <- .print(this_ns, " from ", L, " by ", N); -+level(L + N);
     +done(::level, L + N).
