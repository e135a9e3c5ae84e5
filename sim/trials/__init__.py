"""Trials: files, checks and expectations.

`keys` declares the keys of a file, `building` builds the trial from them, `checks` finds faults of
any trial, and `writing` writes the file. `expectations` compares a run with the expectations.
"""
