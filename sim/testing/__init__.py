"""Parts of the pytest plugin that are imported when there is a trial to run."""
