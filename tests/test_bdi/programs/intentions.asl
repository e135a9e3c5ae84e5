// What intentions say of themselves: their states, with reasons, and the labels of their plans.
!start.
@begin[important] +!start
  <- !!timed; !!event; !!fact; !!stopped; .wait(50);
     .findall(S, .intention(_, S), States); for (.member(S, States)) { .print(S) };
     .findall(R, .intention(_, waiting[reason(R)]), Reasons); .length(Reasons, N); .print(N);
     .findall(S, .intention(_, suspended, [im(S, _, _, _)|_]), Stopped); .print(Stopped);
     .intention(I, C, [im(L, E, _, _)|_], current); .print(I, " ", C, " ", E); .print(L);
     .current_intention(intention(I, [im(_, _, { B; _ }, _)])); .print(B).
+!timed <- .wait(3000).
+!event <- .wait({ +never(X) }, 3000, _).
+!fact <- .wait(never & always, 3000, _).
@stop +!stopped <- .print("stops"); .suspend; .print("not here").
