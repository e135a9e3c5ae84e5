"""Studies: designs that are read from files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from . import study_file
from .definition import Design


@dataclass(frozen=True)
class Study(Design):
    """Trials in variations, as a `Design` has them; it can be loaded."""

    @classmethod
    def load(cls, path: str | Path, *, own_code: bool = True) -> Study:
        """The study in the YAML file at `path`.

        Without `own_code` its trials may name no Python of the user's own, as of `Trial.load`.
        `StudyError` with everything that is wrong, each with its place.
        """
        return study_file.load(cls, path, own_code)

    @classmethod
    def parse(
        cls,
        text: str,
        *,
        file: str = "<text>",
        folder: str | Path = ".",
        own_code: bool = True,
    ) -> Study:
        """The study in `text`, as if it stood in `folder`; errors call it `file`.

        `own_code` is as of `load`.
        """
        return study_file.parse(cls, text, file, Path(folder), own_code)
