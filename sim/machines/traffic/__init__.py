"""Traffic of machines: claims of area, waiting, and ways out of deadlocks."""
