// Plans, events and bodies as terms: taken apart, put together, carried out.
tagged(label(L[|Annots])) :- .print(Annots).

!all.
+!all <- !bodies; !names; !parts; !labels; !made; !guarded(p[a, b]); !rest({ say(1); say(2) }); !me.

+!bodies
  <- X = { one(1); !two; three }; { Head; Tail } = X; .print(Head, " ", Tail);
     { Only } = { !two[now] }; .print(Only).

// A body is a structure that has the name of its first step.
+!names
  <- B = { !g(a)[b] }; B = achieve(Goal); .print(Goal); B = achieve(_[|Annots]); .print(Annots);
     B =.. [achieve, Args, _]; .print(Args); { +b(1) } = addBel(Belief); .print(Belief);
     { ?q; a } = test(Q, Next); .print(Q, " ", Next);
     { +!x : c <- y } = plan(_, _, Context, _); .print(Context).

@known +!plan(1) : 1 > 10 <- say(1); !two; say(3).

// What is taken out of a plan is printed without braces.
+!parts
  <- .relevant_plans({ +!plan(_) }, [Plan|_]);
     Plan =.. [_, Event, Context, Body]; .print(Event, " ", Context, " ", Body).

+!labels
  <- .relevant_plans({ +!plan(_) }, [Plan|_]);
     Plan = { @L +!T : C <- B }; L =.. [Name, _, _]; .print(Name, " ", T, " ", C);
     B = { H; R }; .print(H, " / ", R).

+!made
  <- Plan =.. [big, { +!size(N) }, { N > 10 }, { .print("big ", N) }];
     .add_plan(Plan); .add_plan({ +!size(N) <- .print("small ", N) }); !size(11); !size(2).

+!guarded(G) : tagged(label(G)) <- .print(guarded).

+!rest({ A; R }) <- A; !rest(R).
+!rest(A) <- A; .print(rested).

// An intention that knows itself.
+!me
  <- .current_intention(I); I = intention(_, Stack); .length(Stack, N); .print(N);
     .findall(State, .intention(_, State, _, current), States); .print(States).
