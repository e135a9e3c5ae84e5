"""Trials: their values, their files, and what is expected of their runs.

`keys` says what a file may have, `trial` makes a trial of it, `checks` says what can't be, however
it was made, and `trial_writing` writes it again. `expectations` holds a run to what was expected.
"""
