"""The record of a run: its outcome, and the figures computed from it.

`figures` declares the summary, and `finished` measures it at the end of a simulation. The other
modules work on an `outcome`, which may have been loaded from a folder. They do not know their
viewers.
"""
