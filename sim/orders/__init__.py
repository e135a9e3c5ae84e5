"""Trials of the ARIAC competition: their files, orders, and points."""
