// Worker: does the tasks of the trial's work lists and schedule, and goes home after the shift.
// Ignores the gantry; other programs may include this file in place of
// patrol.asl. Without work it walks from station to station, as that file says.
//
// It perceives
//     work_offered(N), task_done(N)       there is something new to do; a task is done
//     shift_began(N), shift_ended(N)
// and believes, always up to date,
//     offer(Id, Task, Station, Priority, Ms)    what it could take on, the most urgent first
//     doing(Id, Task, Station, X, Y)            its task
//     on_shift
//     works                                     there may be work for it

+human_start : works <- !look_for_work.
+shift_began(_) <- !look_for_work.
+work_offered(_) <- !look_for_work.
+task_done(_) <- !look_for_work.
+shift_ended(_) : not doing(_, _, _, _, _) <- !go_home.
+shift_ended(_).

// The most urgent is chosen; a rule for choice(Id, Station) in front of this one chooses otherwise.
+!look_for_work : doing(_, _, _, _, _).
+!look_for_work : offer(_, _, _, _, _) <- ?choice(Id, S); take(Id); .abolish(errand(_)); !walk_to(S).
+!look_for_work : not on_shift <- !go_home.
+!look_for_work.
-!look_for_work.

choice(Id, S) :- offer(Id, _, S, _, _).

+!walk_to(S) : doing(_, _, S, X, Y) <- -+bound_for(S); move(X, Y, 0).

+!go_home : safe_zone(X, Y) & not errand(home) <- +errand(home); move(X, Y, 0).
+!go_home.
-!go_home.

+work_completed(_) : works & errand(home) <- .abolish(errand(_)).
+work_completed(_) : doing(_, _, _, _, _) & not errand(_) <- !work_here.
+work_completed(_) : works & not errand(_).

// Somebody may stand in the way of the station: after a few tries there may be other things to do.
+!work_here <- begin_task; .abolish(tried(_)).
-!work_here : doing(_, _, S, _, _) <- !try_again(S).
-!work_here.

@violation_at_work[atomic]
+gantry_disabled(_) : works & violation_pause(Ms)
  <- .drop_all_desires; teleport_safe; !compose; .wait(Ms); !!back_to_work.

@danger_at_work[atomic]
+agv_danger(_) : works & agv_pause(Ms)
  <- .drop_all_desires; teleport_agv; !compose; .wait(Ms); !!back_to_work.

+!back_to_work : doing(_, _, S, _, _) <- !walk_to(S).
+!back_to_work <- !look_for_work.

// After a few tries without a path the task is given back, and something else is looked for.
+!try_again(_) : works & not .desire(retry(_)) & tried(N) & most_tries(Most) & N >= Most & blocked_pause(Ms)
  <- .abolish(tried(_)); .abolish(errand(_)); !put_off; .wait(Ms); !look_for_work.

+!put_off : doing(_, _, _, _, _) <- give_back.
+!put_off.

// An AGV on the station is waited for: the person stands beside it, and goes on by itself.
+goal_occupied(_) : works.

{ include("patrol.asl") }
