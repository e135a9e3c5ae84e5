// Internal actions, in bodies and in queries.
age(ann, 30). age(bob, 25). age(cyd, 35).
!start.
+!start
  <- .findall(N, age(N, A) & A > 26, L1); .print(L1);
     .setof(B, age(_, B), L2); .print(L2);
     .count(age(_, _), C); .count(a, [a, b, a], C2); .print(C, " ", C2);
     .max(D, age(_, D), Oldest); .print(Oldest);
     .findall(I, .substring("an", "banana", I), L3); .print(L3);
     .findall(P, .prefix(P, [1, 2]), L4); .findall(S, .suffix(S, [1, 2]), L5);
     .findall(U, .sublist(U, [1, 2]), L6); .print(L4, " ", L5, " ", L6);
     .findall(E, .nth(E, [x, y, x], x), L7); .print(L7);
     .findall(R, .range(R, 10, 1, -4), L8); .print(L8);
     .delete(0, [a, b], L9); .delete(b, [a, b, b], L10); .delete("an", "banana", W); .print(L9, L10, W);
     .replace("a-b-c", "-", "+", W2); .print(W2);
     .concat("n", 1, [2], W3); .length(W3, Len); .print(W3, " ", Len);
     .union([b, a], [c, a], L11); .difference([1, 2, 3], [2], L12); .print(L11, L12);
     .reverse([1, 2, 3], L13); .reverse("abc", W4); .print(L13, W4);
     if (age(Who, Years) & .member(Years, [35, 36])) { .print(Who) };
     .relevant_plans({+!more(_)}, Plans); .length(Plans, K); .print(K, " plan");
     .add_plan({+!more(x) <- .print("one more")}); !more(x);
     .add_plan("@shout +!more(y) <- .print(\"LOUD\").", self, begin); !more(y);
     .remove_plan(shout); !more(y);
     .print("done").
+!more(y) <- .print("quiet").
