"""The record of a run: its outcome, and the figures worked out from it."""
