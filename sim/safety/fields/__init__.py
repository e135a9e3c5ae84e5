"""Protective fields: the safety function below every controller that stops and slows machines."""
