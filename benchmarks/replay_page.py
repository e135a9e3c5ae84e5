"""Cost of the replay page of a long run: `python benchmarks/replay_page.py`.

The run is of 30 people in a warehouse, ten minutes simulated and then repeated for 8 hours. Its
page is opened in Chromium. Times are CPU times of the page's main thread, of its scripts or in all:
what it has to do to draw too, but not what the graphics do (WebGL is done in software, by another
process).
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import floorplan
import sim
from sim.core.recorder import DECIMALS
from sim.views.film import in_browser, open_page
from sim.views.replay import render
from sim.views.replay_data import replay_data

if TYPE_CHECKING:
    from playwright.sync_api import Browser

TRIALS = {
    "patrol": """
floorplan: warehouse
duration: {seconds}
people: [{{name: p, personality: indifferent, count: {people}, at: anywhere}}]
""",
    "shift": """
floorplan: warehouse
duration: {seconds}
people: [{{name: p, personality: worker, count: {people}, at: anywhere, work: [jobs]}}]
work:
  jobs:
    repeat: true
    tasks: {tasks}
""",
}
"""Everybody walks all the time; or works at a station, a minute at a time, or waits for one."""

SIZE = (1000, 640)
"""Pixels of the page."""

FRAMES = """
new Promise(done => {{
  let [t, count] = [{t}, {count}];
  const next = () => {{
    if (count-- === 0) return done();
    floorwalker.seek(t += 1 / 60);
    requestAnimationFrame(() => setTimeout(next));
  }};
  next();
}})
"""
"""Draws a number of frames."""

PARTS = {
    "reading": "readRecording().then(read => { window.read = read; })",
    "preparing": "void (window.run = new Run(read))",
    "events": "void new Band(run, '')",
    "plot": "void run.watches[0]?.largest",
    "jumps": "void [...run.bodies.values()].forEach(({ motion }) => motion.jumps)",
}
"""What opening consists of, done once more."""


class Minds(sim.Listener):
    """Asks for what goes on in people's minds, as a recording does."""

    wants_thoughts = True


def repeated(recording: dict[str, Any], times: int) -> dict[str, Any]:
    """Return a recording in which the same happens `times` times, one after the other."""
    span = recording["duration"]
    shifts = [k * span for k in range(times)]

    def later(things: list[dict[str, Any]]) -> list[dict[str, Any]]:
        return [{**thing, "t": thing["t"] + shift} for shift in shifts for thing in things]

    return {
        **recording,
        "duration": span * times,
        "motions": {
            name: [
                [round(b + s, DECIMALS), round(e + s, DECIMALS), *axes]
                for s in shifts
                for b, e, *axes in pieces
            ]
            for name, pieces in recording["motions"].items()
        },
        "events": later(recording["events"]),
        "minds": {name: later(thoughts) for name, thoughts in recording["minds"].items()},
        "watches": [
            {**w, "violations": [[b + s, e + s] for s in shifts for b, e in w["violations"]]}
            for w in recording["watches"]
        ],
    }


def main() -> None:
    """Measure, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trial", choices=sorted(TRIALS), default="shift")
    parser.add_argument("--people", type=int, default=30)
    parser.add_argument("--hours", type=float, default=8.0)
    parser.add_argument("--seconds", type=float, default=600.0, help="simulated, then repeated")
    parser.add_argument("--keep", type=Path, help="write the page there")
    options = parser.parse_args()
    stations = [station.name for station in floorplan.load("warehouse").stations]
    tasks = [{"at": name, "duration": {"lognormal": [60.0, 20.0]}} for name in stations]
    text = TRIALS[options.trial].format(
        seconds=options.seconds, people=options.people, tasks=json.dumps(tasks * options.people)
    )
    trial = sim.Trial.parse(text)
    data = replay_data(sim.run(trial, Minds()))
    data = repeated(data, round(options.hours * 3600 / options.seconds))
    page = render(data)
    pieces = sum(map(len, data["motions"].values()))
    print(f"{options.people} people, {options.hours:g} h: {pieces:,} pieces of motions,", end=" ")
    print(f"{len(data['events']):,} events")
    print(f"page: {len(page.encode()) / 1e6:.1f} MB")
    with tempfile.TemporaryDirectory() as folder:
        file = options.keep or Path(folder) / "replay.html"
        file.write_text(page, encoding="utf-8")
        in_browser("this", lambda browser: measure(browser, file, data["duration"]))


def measure(browser: Browser, file: Path, duration: float) -> None:
    """Open the page, draw frames of it, and print what each takes."""
    page = open_page(browser, file, size=SIZE)
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})

    def times() -> dict[str, float]:
        metrics = session.send("Performance.getMetrics")["metrics"]
        return {one["name"]: float(one["value"]) for one in metrics}

    def took(work: Callable[[], object]) -> tuple[float, float]:
        """Return the CPU times (s) of the page's main thread, and of its scripts, for some work."""
        before = times()
        work()
        after = times()
        thread, scripts = (after[name] - before[name] for name in ("ThreadTime", "ScriptDuration"))
        return thread, scripts

    def ready() -> None:
        page.reload()
        page.wait_for_selector("body[aria-busy=false]")

    print(f"opening: {took(ready)[0]:.2f} s")
    for name, script in PARTS.items():
        spent, _ = took(lambda script=script: page.evaluate(script))
        print(f"  {name}: {spent:.2f} s")
    for view, count in (("2d", 60), ("3d", 12)):
        page.evaluate(f"floorwalker.show('{view}')")
        for share in (0.1, 0.5, 0.9):
            t = share * duration
            page.evaluate(FRAMES.format(t=t, count=3))
            draw = FRAMES.format(t=t, count=count)
            thread, scripts = took(lambda draw=draw: page.evaluate(draw))
            each = f"{1000 * scripts / count:.2f} ms of scripts"
            print(f"{view} at {t:.0f} s: {each}, {1000 * thread / count:.2f} ms in all a frame")


if __name__ == "__main__":
    main()
