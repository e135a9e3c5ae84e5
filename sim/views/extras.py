"""What is said where a package of an extra is missing."""


class MissingExtraError(ImportError, ValueError):
    """A package that Floorwalker can do without, but not here; the message says how to get it."""
