"""The error of a missing extra."""

from floorplan import UserError


class MissingExtraError(ImportError, UserError):
    """A package that Floorwalker can do without, but not here; the message says how to get it."""
