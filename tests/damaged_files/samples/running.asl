// What it does ends by itself, and can be damaged so that it does not.
n(0). n(1). n(2). edge(a, b). edge(b, c).
path(X, Y) :- edge(X, Y).
path(X, Z) :- edge(X, Y) & path(Y, Z).
!go(0).
+!go(N) : N < 3 & path(a, c) <- +seen(f(N, N)); .wait(100); !go(N + 1).
+!go(N) <- for (n(K) & K > 0) { .print("k", K) }; .findall(X, .range(X, 1, 4), L); !sum(L, 0).
+!sum([H|T], S) <- !sum(T, S + H * 2).
+!sum([], S) <- .concat("sum ", S, Text); .print(Text); X = f(S, [S|S]); report(X); -n(_); !!end.
+!end <- while (n(K)) { -n(K) }; .findall(P, path(P, _), Ps); .length(Ps, C); .sort(Ps, Q); done(Q, C).
-!go(N)[error(E), error_msg(M)] <- .print(E, M); .fail.
+seen(X)[source(S)] <- .random(R); .my_name(Me); ?n(Y); .substring("a", "banana", I).
