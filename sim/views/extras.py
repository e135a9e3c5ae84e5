"""The error of a missing extra."""


class MissingExtraError(ImportError, ValueError):
    """A package that Floorwalker can do without, but not here; the message says how to get it."""
