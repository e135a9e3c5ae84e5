"""Base of the pydantic models of files."""

from pydantic import BaseModel, ConfigDict


class Strictly(BaseModel):
    """Base of pydantic models for parts of files. It rejects unknown keys.

    The modules of such models do not postpone annotations, because pydantic would compile each.
    """

    model_config = ConfigDict(
        extra="forbid", frozen=True, str_strip_whitespace=True, defer_build=True
    )
