// What an agent does with messages, beyond a single belief that it is told and a single goal that it
// is to achieve. Plans of a program for +!kqml_received(Sender, Force, Content, Message) come first.

@kqml_tell[atomic]
+!kqml_received(Sender, tell, Content, _)
   : .literal(Content) & .ground(Content) & not .list(Content) & .add_nested_source(Content, Sender, Belief)
  <- ++Belief.
@kqml_tell_list
+!kqml_received(Sender, tell, Content, _) : .list(Content) <- !kqml_tell_all(Sender, Content).

+!kqml_tell_all(_, []).
+!kqml_tell_all(Sender, [First|Others]) : .literal(First) & .ground(First)
  <- .add_nested_source(First, Sender, Belief); ++Belief; !kqml_tell_all(Sender, Others).
+!kqml_tell_all(Sender, [_|Others]) <- !kqml_tell_all(Sender, Others).

@kqml_untell[atomic]
+!kqml_received(Sender, untell, Content, _) : .add_nested_source(Content, Sender, Belief) <- --Belief.

@kqml_achieve
+!kqml_received(Sender, achieve, Content, _)
   : not .list(Content) & .add_nested_source(Content, Sender, Goal)
  <- !!Goal.
@kqml_achieve_list
+!kqml_received(Sender, achieve, Content, _) : .list(Content) <- !kqml_achieve_all(Sender, Content).

+!kqml_achieve_all(_, []).
+!kqml_achieve_all(Sender, [First|Others])
  <- .add_nested_source(First, Sender, Goal); !!Goal; !kqml_achieve_all(Sender, Others).

@kqml_unachieve[atomic]
+!kqml_received(_, unachieve, Content, _) <- .drop_desire(Content).

@kqml_ask_one
+!kqml_received(Sender, askOne, Content, Message) : kqml.answer(Content, Answer)
  <- .send(Sender, tell, Answer, Message).
@kqml_ask_one_by_plan
+!kqml_received(Sender, askOne, Content, Message)
  <- .add_nested_source(Content, Sender, Asked);
     ?Asked;
     .remove_source_annot(Asked, Answer);
     .send(Sender, tell, Answer, Message).
@kqml_ask_one_in_vain
-!kqml_received(Sender, askOne, Content, Message)[error(test_goal_failed)]
  <- .send(Sender, untell, Content, Message).

@kqml_ask_all
+!kqml_received(Sender, askAll, Content, Message)
  <- .findall(Answer, kqml.answer(Content, Answer), Answers); .send(Sender, tell, Answers, Message).

@kqml_tell_how
+!kqml_received(Sender, tellHow, Content, _)
  <- .remove_source_annot(Content, Plans); .add_plan(Plans, Sender).
@kqml_untell_how
+!kqml_received(Sender, untellHow, Content, _) <- .remove_plan(Content, Sender).
@kqml_ask_how
+!kqml_received(Sender, askHow, Content, Message)
  <- .relevant_plans(Content, Found); .remove_source_annot(Found, Plans);
     .send(Sender, tellHow, Plans, Message).

@kqml_signal
+!kqml_received(Sender, signal, Content, _)
   : not .list(Content) & .add_nested_source(Content, Sender, Event)
  <- .signal({+Event}).

@kqml_error
-!kqml_received(_, _, _, _)[error(Error), error_msg(Message)]
  <- .print("Communication error -- ", Error, ": ", Message).
