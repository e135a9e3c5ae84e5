"""The record of a run: its outcome, and the figures worked out from it.

`figures` declares what a summary has, `finished` measures it in a simulation at its end; all else
works on an `outcome`, which may have been read back from a folder. Nothing here knows who looks.
"""
