"""What the pytest plugin does once there is a trial to run; imported only then."""
