"""Machines: what they are, and one folder for each kind."""
