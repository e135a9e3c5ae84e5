"""Avoidance: motions of people that never conflict."""
