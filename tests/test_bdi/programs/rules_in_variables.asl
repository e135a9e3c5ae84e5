// Rules and plans that are added and removed by a variable that stands for them.
q(1). q(2). r(5).
!start.
+!start
  <- R = { p(X) :- q(X) }; +R; !list; Bob = { p(9) :- r(_) }; +Bob[source(bob)]; !list;
     .findall(S, p(9)[source(S)], L); .print(L); -R; !list;
     Last = { p(X + 1) :- r(X) }; +>Last; !list; -{ p(Y + 1) :- r(Y) }; !list;
     Limit = 7; +{ big(X) :- X > Limit }; if (big(8) & not big(7)) { .print("big") };
     P = { +!greet(Name) <- .print("hello ", Name) }; +P; !greet(ann); !number.
+!list <- .findall(X, p(X), L); .print(L).
+!number <- N = 3; +N.
-!number[error(E)] <- .print(E).
