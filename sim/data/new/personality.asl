// A person who walks from station to station, and lets the gantry pass.
// Run it with
//   floorwalker run ariac2023 --personality {file}
// or name it in a trial beside this file: people: [{{name: eve, personality: {file}}}]

// Beliefs: facts that plans can use. A trial can add others.
pause(4000).  // ms

// A plan: event : context <- actions. This one runs when the person notices the gantry on the way to S.
+gantry_detected(_) : bound_for(S) & pause(Ms)
  <- stop_movement; .drop_all_desires; face_gantry; .wait(Ms); !walk_to(S).

// The other plans are built in: a round of all stations, again after a violation or a blocked path.
{{ include("patrol.asl") }}
