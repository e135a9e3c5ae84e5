"""A custom gantry controller that shuttles between two bins."""


def shuttle(gantry):
    """Back and forth, with a rest after each way."""
    while True:
        yield gantry.move_to(-2.3, 3.0)
        yield gantry.wait(2.0)
        yield gantry.move_to(-2.3, -3.0, rotation=1.57)
        yield gantry.wait(2.0)
