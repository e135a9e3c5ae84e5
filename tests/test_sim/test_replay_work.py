"""Work per frame of the replay page, limited so that slow machines show 60 frames per second."""

import copy

import pytest
import replay_sample
from replay_sample import replay

pytestmark = pytest.mark.slow  # browsers draw in software

MOST_CALLS = 1500
"""Maximum number of calls to the canvas for a frame with seven bodies."""

MOST_EVALUATIONS = 150
"""Maximum number of positions of bodies computed for a frame."""

COUNT = """
t => new Promise(done => {
  const counts = { canvas: 0, motion: 0 };
  const undo = [];
  const count = (prototype, name, what) => {
    const original = Object.getOwnPropertyDescriptor(prototype, name);
    if (typeof original.value !== "function" || name === "constructor") return;
    prototype[name] = function (...values) {
      counts[what] += 1;
      return original.value.apply(this, values);
    };
    undo.push(() => Object.defineProperty(prototype, name, original));
  };
  const context = CanvasRenderingContext2D.prototype;
  for (const name of Object.getOwnPropertyNames(context)) count(context, name, "canvas");
  for (const name of ["at", "before"]) count(Motion.prototype, name, "motion");
  floorwalker.seek(t);
  requestAnimationFrame(() => setTimeout(() => {
    for (const restore of undo) restore();
    done(counts);
  }));
})
"""

INSTANTS = [20.0, 62.0, 66.5, 80.0, 141.0, 182.0, 216.0]


def work(viewer, t):
    """Return the work of the frame at `t`, when only the time has changed since the last frame."""
    viewer.seek(t - 1 / 60)
    return viewer.page.evaluate(COUNT, t)


def lengthened(recording, times):
    """Return the recording repeated `times` times, with the violations of the first time only."""
    longer = copy.deepcopy(recording)
    span = recording["duration"]
    longer["duration"] = span * times
    for name, pieces in recording["motions"].items():
        longer["motions"][name] = [
            [begin + k * span, end + k * span, *axes]
            for k in range(times)
            for begin, end, *axes in pieces
        ]
    longer["events"] += [
        {**event, "t": event["t"] + k * span}
        for k in range(1, times)
        for event in recording["events"]
        if event["kind"] != "violation"
    ]
    for watch in longer["watches"]:
        watch["violations"] = [
            [begin + k * span, end + k * span]
            for k in range(times)
            for begin, end in watch["violations"]
        ]
    return longer


@pytest.fixture(scope="module")
def recording():
    return replay_sample.recording()


def test_a_frame_is_little_work(open_page, recording):
    viewer = open_page(replay.render(recording))
    for t in INSTANTS:
        done = work(viewer, t)
        assert 50 < done["canvas"] < MOST_CALLS, t
        assert 10 < done["motion"] < MOST_EVALUATIONS, t


def test_a_frame_of_a_long_recording_is_no_more_work(open_page, recording):
    short = open_page(replay.render(recording))
    long = open_page(replay.render(lengthened(recording, 12)))
    for t in INSTANTS:
        assert work(long, t) == work(short, t)


def test_a_frame_with_very_many_violations_is_bounded(open_page, recording):
    [violation, *_] = [e for e in recording["events"] if e["kind"] == "violation"]
    counts = []
    for number in (400, 800):
        many = copy.deepcopy(recording)
        many["events"] += [{**violation, "t": 0.1 + k * 1e-4} for k in range(number)]
        many["events"].sort(key=lambda event: event["t"])
        counts.append(work(open_page(replay.render(many)), 141.0))
    assert counts[0] == counts[1]
