"""Runs: to look at, to keep in a folder, and to read back."""
