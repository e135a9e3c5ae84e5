// Terms: numbers, strings, lists, order, taking apart.
!start.
+!start
  <- .print(1.0, " ", 2.50, " ", 1/3, " ", 1e3, " ", 1.0e-5, " ", 12345678.9, " ", 10/4*2);
     .print(7 mod 3, " ", -7 mod 3, " ", -7 div 2, " ", 2**3**2, " ", 0.1+0.2, " ", 1/0);
     .print("a \"quoted\" word", " ", f("inside"), " ", 'An Atom', " ", [1, "s", x|[y]]);
     .sort([z, "b", f(1), 3, [2, 1], g(0, 0), "a", [9], 1, b], L); .print(L);
     .max([2, b, "x"], Max); .min([f(2), f(1)], Min); .print(Max, " ", Min);
     T =.. [move, [1, 2], [fast]]; .print(T);
     p(a, B) =.. P; .print(P);
     [H, H2|Rest] = [1, 2, 3, 4]; .print(H, H2, " ", Rest);
     if (f(X, X) = f(1, Y)) { .print("Y=", Y) };
     if (1 == 1.0 & a \== b & not a == "a") { .print("equal and not") };
     if (10 < "1" & "z" < [] & [] < a & a < f(a) & f(b) < ~f(a)) { .print("in order") };
     .print(Free, " ", q(Free));
     .print(not a & b | c, " ", X > 3, " ", {+!g(1)});
     .term2string(Back, "[f(1), \"s\"]"); .print(Back);
     .print(math.round(2.5), " ", math.round(-2.5), " ", math.max(3, 7), " ", math.sum([1, 2, 3]));
     .print("done").
