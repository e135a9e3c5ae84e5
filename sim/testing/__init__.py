"""Parts of the pytest plugin that are imported once there is a trial to run."""
