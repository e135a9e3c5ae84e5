"""What is left of a run: its record, in memory and on disk."""
