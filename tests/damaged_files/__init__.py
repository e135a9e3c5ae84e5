"""Damaged files: each is read, or rejected with a message that names the damage."""
