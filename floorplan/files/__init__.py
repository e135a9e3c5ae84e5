"""Toolkit of all packages but `bdi`: reading files, checking values, wording problems."""
