"""Trials: their values, their files, and what is expected of their runs.

`keys` says what a file may have, `building` makes a trial of it, `checks` says what can't be,
however it was made, and `writing` writes it again. `expectations` holds a run to what was expected.
"""
