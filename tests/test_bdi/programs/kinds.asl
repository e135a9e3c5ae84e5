// All kinds of which a term is.
!start.
+!kinds(X) <- .findall(K, .type(X, K), L); .print(X, " ", L).
+!start
  <- for (.member(X, [1, "s", a, f(1), ~a, a[x], [1], []])) { !kinds(X) };
     !kinds({ .print(1) }); !kinds({ +b }); !kinds({ !g; +b }); !kinds({ +!g });
     !kinds({ +!g <- a }); !kinds({ a(1) :- b }); !kinds((a & b)); !kinds((1 < 2));
     .set.create(S); !kinds(S); .map.create(M); !kinds(M); .queue.create(Q); !kinds(Q);
     .findall(K, .type(Open, K), L); .print(L);
     if (.type({ a }, plan) & not .type({ +!g <- a }, plan)) { .print("a body is a plan") }.
