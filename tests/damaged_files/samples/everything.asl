// A program with some of everything.
{ include("patrol.asl") }
{ include("other.asl") }
at(home)[source(self)]. ~cold. far(X) :- dist(X, D) & D > 2 & not near(X) | X = 3.
!begin(1).
@p1[atomic] +!begin(N) : N < 10 & far(_) <- ?at(P); .concat("a", P, S); !begin(N+1).
+!begin(N) <- if (N > 3) { -+at(away) } else { move(1.5, -2, [a, b|T]) }; .wait(1000).
-!begin(N)[error(E)] <- .print("failed ", E); .findall(X, at(X), L); for (.member(M, L)) { x(M) }.
+human_start : true <- .drop_all_desires; !!begin(0); .range(1, 5, R); .nth(2, R, Q).
+b(X)[source(percept)] <- X =.. [F, A, B]; while (X < 3) { +c(X) }; .add_plan({+!k <- a}, self).
+!par <- (!a |&| !b); (c ||| d); Y = 3 mod 2 ** -1 / (4 div 5); .send(robot, tell, f(Y)); 'Odd name'.
