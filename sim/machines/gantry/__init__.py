"""The gantry robot: drives, what its controller sees, and controllers."""
