"""Distances between people and machines: laws, what watches them, and the referee."""
