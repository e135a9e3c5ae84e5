"""Runs that are watched as they happen."""
