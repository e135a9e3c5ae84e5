"""Readers of floors in other formats: DXF, GeoJSON, WKT, MovingAI and ROS maps."""
