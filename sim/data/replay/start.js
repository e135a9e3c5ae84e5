/* Reads the recordings of the page, shows them, and takes dropped files. */

/** Says what is wrong with a recording, instead of the page. */
function showTrouble(why) {
  $("trouble").querySelector("ul").replaceChildren(...troubles(why));
  $("trouble").hidden = false;
  $("replay").hidden = true;
}

/** The same in a dialog, while the page still shows a good recording. */
function showDropTrouble(name, why) {
  const dialog = $("drop-trouble");
  dialog.querySelector("p").textContent = `${name} can't be shown:`;
  dialog.querySelector("ul").replaceChildren(...troubles(why));
  if (!dialog.open) dialog.showModal();
}

function troubles(why) {
  const problems = why instanceof RecordingError ? why.problems : [`unexpected: ${why.message}`];
  const shown = problems.slice(0, MOST_PROBLEMS);
  if (problems.length > shown.length) shown.push(`… and ${problems.length - shown.length} more`);
  return shown.map(problem => element("li", { text: problem }));
}

/** A file that is dropped or chosen is compared with what is shown. */
function takeFiles(replay) {
  const take = async file => {
    if (!file) return;
    try {
      replay.compare(new Run(await readFile(await file.text())));
    } catch (why) {
      showDropTrouble(file.name, why);
    }
  };
  const isFile = event => event.dataTransfer?.types.includes("Files");
  document.addEventListener("dragover", event => {
    if (!isFile(event)) return;
    event.preventDefault();
    document.body.classList.add("dropping");
  });
  document.addEventListener("dragleave", event => {
    if (!event.relatedTarget) document.body.classList.remove("dropping");
  });
  document.addEventListener("drop", event => {
    if (!isFile(event)) return;
    event.preventDefault();
    document.body.classList.remove("dropping");
    take(event.dataTransfer.files[0]);
  });
  $("other-file").addEventListener("change", event => {
    take(event.target.files[0]);
    event.target.value = "";
  });
  $("compare").addEventListener("click", () => $("other-file").click());
}

document.addEventListener("DOMContentLoaded", async () => {
  document.body.ariaBusy = "true"; // a packed recording takes a while
  try {
    const recording = await readRecording();
    $("cut-off").remove();
    $("replay").hidden = false;
    const replay = new Replay(new Run(recording));
    takeFiles(replay);
    if ($("other")) replay.compare(new Run(await readRecording("other")));
    if (document.documentElement.dataset.stream) followStream(replay, recording);
    const linked = Number.parseFloat(new URLSearchParams(location.hash.slice(1)).get("t"));
    if (Number.isFinite(linked)) replay.clock.seek(linked);
    const wanted = new URLSearchParams(location.hash.slice(1)).get("view");
    if (wanted === "3d") replay.showSpace(true);
    if (wanted === "eyes") replay.lookThrough(true);
    /**
     * For scripts and tests. `watch` is a place in recording.watches; times are seconds.
     *   pose(body, t)        -> {x, y, rotation, vx, vy, speed}
     *   separation(watch, t) -> {distance, required, margin, notice, personSpeed, otherSpeed, violated}
     *   field(kind, t, x, y) -> {value, density, x, y} of the cell there; kind: density, speed, run-density, run-speed
     *   film({view, speed, follow})   shows the floor alone, for a film that goes `speed` times as fast as in reality
     *   compare(recording)   shows another one beside this one
     *   show(view)           "2d", "3d", or "eyes": through the eyes of the person in focus
     *   place(x, y, z)       -> [px, py] on the floor's canvas, or null if it is behind the viewer
     */
    window.floorwalker = {
      get recording() { return replay.runs[0].recording; },
      get time() { return replay.clock.time; },
      seek: t => replay.clock.seek(t),
      play: () => replay.clock.play(),
      pause: () => replay.clock.pause(),
      pose: (body, t) => replay.runs[0].bodies.get(body).motion.at(t),
      separation: (watch, t) => replay.runs[0].watches[watch].at(t),
      show: view => (view === "eyes" ? replay.lookThrough(true) : replay.showSpace(view === "3d")),
      field: (kind, t, x, y) => replay.runs[0].fields.valueAt(kind, t, x, y),
      film: look => replay.film(look),
      place: (x, y, z = 0) => replay.views[0].camera.toScreen(x, y, z)?.slice(0, 2) ?? null,
      compare: other => replay.compare(new Run(parseRecording(JSON.stringify(other)))),
    };
  } catch (why) {
    $("cut-off")?.remove();
    showTrouble(why);
  } finally {
    document.body.ariaBusy = "false";
  }
});
