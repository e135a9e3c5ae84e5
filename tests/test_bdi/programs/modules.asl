// One file in two namespaces: each has beliefs, plans and labels of its own.
{ include("modules/counter.asl", left) }
{ include("modules/counter.asl", right) }
level(7).
!start.
+!start
  <- !left::raise(2); !right::raise(5); ?left::level(A); ?right::level(B); ?level(C);
     .print(A, " ", B, " ", C); .findall(N, N::level(_), Ns); .sort(Ns, S); .print(S);
     .relevant_plans({ +!left::raise(_) }, _, L); .print(L);
     .remove_plan(right::raising); .relevant_plans({ +!right::raise(_) }, Ps); .print(Ps);
     !names; !unify; !argument(left::a).
-!start[error(E)] <- .print(E).

// A variable has the namespace that is written before it.
+!names <- for (.member(N::X, [left::a, b])) { .print(N, " ", X) };
     .findall(X, .member(X, [left::a, b]), L); .print(L); X = c; left::X = Y; .print(Y).
-!names[error(E)] <- .print(E).
+!unify : X = left::a(1) <- .print("not here").
+!unify : left::X = left::a(1) & N::b(Y) = right::b(2) & left::Z = 3
  <- .print(X, " ", N, " ", Y, " ", Z).
+!argument(X) <- .print("not here").
+!argument(N::X) <- .print(X, " in ", N).

+left::done(left::level, X) <- .print("left is done: ", X).
+right::done(X, Y) <- .print("not here").
