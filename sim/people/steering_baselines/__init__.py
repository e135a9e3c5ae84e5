"""Baselines of the literature for the steering of people: social force and ORCA."""
