// What an agent does with messages, beyond a single belief that it is told and a single goal that it
// is to achieve. Plans of a program for +!kqml_received(Sender, Force, Content, Message) come first.
// NS is the namespace of what is said.

@kqml_tell[atomic]
+!kqml_received(Sender, tell, NS::Content, _)
   : .literal(NS::Content) & .ground(NS::Content) & not .list(NS::Content) & .add_nested_source(NS::Content, Sender, NS::Belief)
  <- ++NS::Belief.
@kqml_tell_list
+!kqml_received(Sender, tell, NS::Content, _) : .list(NS::Content) <- !kqml_tell_all(Sender, NS::Content).

+!kqml_tell_all(_, []).
+!kqml_tell_all(Sender, [NS::First|Others]) : .literal(NS::First) & .ground(NS::First)
  <- .add_nested_source(NS::First, Sender, NS::Belief); ++NS::Belief; !kqml_tell_all(Sender, Others).
+!kqml_tell_all(Sender, [NS::_|Others]) <- !kqml_tell_all(Sender, Others).

@kqml_untell[atomic]
+!kqml_received(Sender, untell, NS::Content, _) : .add_nested_source(NS::Content, Sender, NS::Belief) <- --NS::Belief.

@kqml_achieve
+!kqml_received(Sender, achieve, NS::Content, _)
   : not .list(NS::Content) & .add_nested_source(NS::Content, Sender, NS::Goal)
  <- !!NS::Goal.
@kqml_achieve_list
+!kqml_received(Sender, achieve, NS::Content, _) : .list(NS::Content) <- !kqml_achieve_all(Sender, NS::Content).

+!kqml_achieve_all(_, []).
+!kqml_achieve_all(Sender, [NS::First|Others])
  <- .add_nested_source(NS::First, Sender, NS::Goal); !!NS::Goal; !kqml_achieve_all(Sender, Others).

@kqml_unachieve[atomic]
+!kqml_received(_, unachieve, NS::Content, _) <- .drop_desire(NS::Content).

@kqml_ask_one
+!kqml_received(Sender, askOne, NS::Content, Message) : kqml.answer(NS::Content, NS::Answer)
  <- .send(Sender, tell, NS::Answer, Message).
@kqml_ask_one_by_plan
+!kqml_received(Sender, askOne, NS::Content, Message)
  <- .add_nested_source(NS::Content, Sender, NS::Asked);
     ?NS::Asked;
     .remove_source_annot(NS::Asked, NS::Answer);
     .send(Sender, tell, NS::Answer, Message).
@kqml_ask_one_in_vain
-!kqml_received(Sender, askOne, NS::Content, Message)[error(test_goal_failed)]
  <- .send(Sender, untell, NS::Content, Message).

@kqml_ask_all
+!kqml_received(Sender, askAll, NS::Content, Message)
  <- .findall(NS::Answer, kqml.answer(NS::Content, NS::Answer), Answers); .send(Sender, tell, Answers, Message).

@kqml_tell_how
+!kqml_received(Sender, tellHow, NS::Content, _)
  <- .remove_source_annot(NS::Content, Plans); .add_plan(Plans, Sender).
@kqml_untell_how
+!kqml_received(Sender, untellHow, NS::Content, _) <- .remove_plan(NS::Content, Sender).
@kqml_ask_how
+!kqml_received(Sender, askHow, NS::Content, Message)
  <- .relevant_plans(NS::Content, Found); .remove_source_annot(Found, Plans);
     .send(Sender, tellHow, Plans, Message).

@kqml_signal
+!kqml_received(Sender, signal, NS::Content, _)
   : not .list(NS::Content) & .add_nested_source(NS::Content, Sender, NS::Event)
  <- .signal({+NS::Event}).

@kqml_error
-!kqml_received(_, _, NS::_, _)[error(Error), error_msg(Message)]
  <- .print("Communication error -- ", Error, ": ", Message).
