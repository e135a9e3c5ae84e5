"""Recorded runs, their events by kind and field, and sums of thoughts, for tests."""

import sim
from sim.core.recorder import Figure as Figure, Scene as Scene
from sim.record.summary import figures_in_words as figures_in_words
from sim.runs.run import Recorded as Recorded


def record(trial, folder):
    """Run a trial, record it in a folder, and return the run."""
    recording = sim.Recording(folder)
    run = sim.run(trial, recording)
    recording.finish(run)
    return run


def events(run, *kinds, **fields):
    """Return the events of any of `kinds` with these values of fields, in order."""
    return [
        event
        for event in run.events
        if event["kind"] in kinds and all(event.get(key) == fields[key] for key in fields)
    ]


def first(run, *kinds, after=0.0):
    """Return the first event of any of `kinds` at or after `after` (s)."""
    return next(event for event in events(run, *kinds) if event["t"] >= after)


def said(run):
    """Return everything that people say, in order."""
    return [event["text"] for event in events(run, "said")]


def beliefs_after(thoughts):
    """Return the beliefs after these thoughts, from their changes alone."""
    beliefs = set()
    for thought in thoughts:
        beliefs -= set(thought.get("forgets", ()))
        beliefs |= set(thought.get("believes", ()))
    return beliefs
