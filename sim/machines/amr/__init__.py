"""Vehicles that drive freely (AMRs)."""
