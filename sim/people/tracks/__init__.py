"""Tracks of people who were measured, from the files of those who measured them."""
