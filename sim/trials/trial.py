"""Trials: scenarios that are read from files, and written into them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import bdi

from ..core.output import write_whole
from ..core.scenario import Scenario
from ..people.own_actions import modules_of
from ..people.programs import load_program
from . import trial_file
from .trial_writing import to_yaml


@dataclass(frozen=True)
class Trial(Scenario):
    """Everything that decides a run, as a `Scenario` has it; it can be loaded and saved."""

    @classmethod
    def load(cls, source: str | Path, *, own_code: bool = True) -> Trial:
        """The built-in trial called `source`, or the one in the YAML file at `source`.

        Python of the user's own that it names (a controller, a law) has to stand beside it. It is
        read, but not imported before the trial is run; without `own_code` it is refused.
        Raises `TrialError` (or `FloorplanError`, `bdi.ProgramError` for what it names) with
        everything that is wrong, each with its place.
        """
        return trial_file.load(cls, source, own_code)

    @classmethod
    def parse(
        cls,
        text: str,
        *,
        file: str = "<text>",
        folder: str | Path = ".",
        own_code: bool = True,
    ) -> Trial:
        """The trial in `text`, as if it stood in `folder`; errors call it `file`.

        `own_code` is as of `load`.
        """
        return trial_file.parse(cls, text, file, Path(folder), own_code)

    def to_yaml(self, folder: str | Path = ".") -> str:
        """The text of a trial file that stands in `folder`, to be read as the same trial.

        A floor that came from no file is written into it. `ValueError` if its orders, a law or a
        program came from no file, if the floor is not sound, or if it names code of the user's own
        that stands neither in `folder` nor above it.
        """
        return to_yaml(self, Path(folder))

    def save(self, path: str | Path) -> None:
        """Write the trial into the file at `path`, from where its files are found as well."""
        path = Path(path)
        write_whole(path, self.to_yaml(path.parent))

    def with_personality(self, personality: str | bdi.Program) -> Trial:
        """Return the same trial in which everybody has this personality all along.

        It is as in `PersonEntry`. `TrialError` if there is none of that name, `bdi.ProgramError`
        if there is something wrong in it.
        """
        for actions in dict.fromkeys(person.actions for person in self.people):
            modules = modules_of(actions, self.actions)
            load_program(personality, self.folder, modules, own_code=self.own_code)
        people = tuple(
            replace(person, personality=personality, changes=()) for person in self.people
        )
        return replace(self, people=people)
