"""Trials: their values, their files, and what is expected of their runs."""
