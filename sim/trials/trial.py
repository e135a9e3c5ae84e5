"""Trials: load, parse and save them. What reads their files is imported when one is read."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import bdi
from floorplan import Problem
from floorplan.files.documents import parse_yaml, read_yaml
from floorplan.files.problems import suggestion
from floorplan.files.reading import is_there

from ..core.custom_code import CodeFolder
from ..core.scenario import Scenario, TrialError
from ..record.output import write_whole

BUILT_IN = Path(__file__).parents[1] / "data" / "trials"
"""Folder of the trials that come with Floorwalker."""

MOST_NAMED = 5
"""Most people whom a trial names as it is shown."""


def builtin_trials() -> tuple[str, ...]:
    """Return the names of the trials that come with Floorwalker, sorted."""
    return tuple(sorted(path.stem for path in BUILT_IN.glob("*.yaml")))


class Trial(Scenario):
    """Everything that decides a run, as a `Scenario` has it; it can be loaded and saved."""

    def __repr__(self) -> str:
        people = ", ".join(person.name for person in self.people[:MOST_NAMED]) or "nobody"
        more = len(self.people) - MOST_NAMED
        people += f" and {more} more" if more > 0 else ""
        about = f"{self.duration:g} s on {self.floorplan.name!r} with {people}, seed {self.seed}"
        return f"<{type(self).__name__} {self.name!r}: {about}>"

    @classmethod
    def load(cls, source: str | Path, *, own_code: bool = True) -> Trial:
        """Return the built-in trial called `source`, or the one in the YAML file at `source`.

        Python of the user's own that it names (a controller, a law) has to stand beside it. It is
        read, but not imported before the trial is run; without `own_code` it is refused.
        Raises `TrialError` (or `FloorplanError`, `bdi.ProgramError` for what it names) with
        everything that is wrong, each with its place.
        """
        from .building import build

        name = str(source)
        if name in builtin_trials():
            text = (BUILT_IN / f"{name}.yaml").read_text(encoding="utf-8")
            return cls.parse(text, file=name, own_code=own_code)
        path = Path(source)
        if not path.suffix and not is_there(path):
            message = f"no such file, nor a built-in trial; {suggestion(name, builtin_trials())}"
            raise TrialError(name, [Problem(message)])
        if path.suffix == ".asl":
            message = "is a program, not a trial; a trial names it as a `personality`"
            raise TrialError(name, [Problem(message)])
        return build(cls, read_yaml(path, TrialError), CodeFolder(path.parent, own_code))

    @classmethod
    def parse(
        cls,
        text: str,
        *,
        file: str = "<text>",
        folder: str | Path = ".",
        own_code: bool = True,
    ) -> Trial:
        """Return the trial in `text`, as if it stood in `folder`; errors call it `file`.

        `own_code` is as of `load`.
        """
        from .building import build

        return build(cls, parse_yaml(text, file, TrialError), CodeFolder(Path(folder), own_code))

    def to_yaml(self, folder: str | Path = ".") -> str:
        """Return the text of a trial file that stands in `folder`, to be read as the same trial.

        A floor that came from no file is written into it. `ValueError` if its orders, a law or a
        program came from no file, if the floor is not sound, or if it names code of the user's own
        that stands neither in `folder` nor above it.
        """
        from .writing import to_yaml

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
        from ..people.programs import load_program, modules_of

        for actions in dict.fromkeys(person.actions for person in self.people):
            modules = modules_of(actions, self.actions)
            load_program(personality, self.code_folder, modules)
        return self.with_people(lambda one: replace(one, personality=personality, changes=()))
