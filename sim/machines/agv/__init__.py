"""AGVs on their lanes."""
