"""Runs in the browser: the replay page, and one that shows a run while it goes on."""
