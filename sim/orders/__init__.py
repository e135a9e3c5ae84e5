"""Trials of the ARIAC competition: their files, their orders, and the points for them."""
