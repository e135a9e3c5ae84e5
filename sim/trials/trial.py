"""Trials: load, parse and save them. Readers are imported when they are used."""

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
"""Maximum number of people in the representation of a trial."""


def builtin_trials() -> tuple[str, ...]:
    """Return the names of the built-in trials in alphabetical order."""
    return tuple(sorted(path.stem for path in BUILT_IN.glob("*.yaml")))


class Trial(Scenario):
    """Trial that can be loaded and saved. The same trial has the same run, byte for byte.

    Parameters
    ----------
    floorplan : Floorplan
        The floor.
    name : str, optional
        Name of the trial.
    duration : float, optional
        Duration in seconds.
    seed : int, optional
        Random seed.
    rules : RuleSet, optional
        Separation rules.
    planner : PlannerChoice, optional
        Path planner of people.
    people : tuple of PersonEntry, optional
        People.
    gantry : GantryEntry, optional
        Gantry of the floor.
    agvs : dict, optional
        Moves of AGVs (`AgvMove`) by the name of the AGV.
    yielding : frozenset of str, optional
        Names of the AGVs that yield to people.
    steering : str, optional
        Custom steering of all people as `module:Class`.
    actions : str, optional
        Module beside the trial with internal actions for all people.
    machines : dict of str to MachineEntry, optional
        Machines that are not in the floorplan.
    fields : dict of str to MachineFields, optional
        Protective fields by the name of the machine.
    expect : dict, optional
        Expectations, as in a trial file.
    folder : Path, optional
        Folder of the files that the trial names.
    floorplan_source : str, optional
        Name or file of the floorplan, if it has one.
    workload : Workload, optional
        Orders of an ARIAC trial.
    until_submitted : bool, optional
        Whether the run ends when all orders are submitted.
    notices : tuple of Problem, optional
        Warnings about the trial file.
    own_code : bool, optional
        Whether the trial may use custom Python code.
    work : dict of str to WorkList, optional
        Shared work lists.
    doors : dict of str to DoorTimes, optional
        Times at which doors are open or closed.
    obstacles : tuple of TimedObstacle, optional
        Temporary obstacles.
    blackouts : tuple of Blackout, optional
        Time spans in which machines do not detect people.
    commands : tuple of Command, optional
        External commands.
    sources : dict, optional
        Sources of assumed values, for reports.
    traffic : bool, optional
        Whether machines wait for each other. Otherwise they may collide.
    """

    def __repr__(self) -> str:
        people = ", ".join(person.name for person in self.people[:MOST_NAMED]) or "nobody"
        more = len(self.people) - MOST_NAMED
        people += f" and {more} more" if more > 0 else ""
        about = f"{self.duration:g} s on {self.floorplan.name!r} with {people}, seed {self.seed}"
        return f"<{type(self).__name__} {self.name!r}: {about}>"

    def _repr_html_(self) -> str:
        """Return a table of the trial for notebooks."""
        from ..record.notebook import html_table

        people = (f"{person.name} ({person.personality_name})" for person in self.people)
        gantry = [f"gantry ({self.gantry.controller_name})"] if self.floorplan.gantry else []
        lanes = (lane.name for lane in self.floorplan.lanes)
        rows = {
            "trial": self.name,
            "floor": self.floorplan.title or self.floorplan.name,
            "duration": f"{self.duration:g} s",
            "seed": f"{self.seed}",
            "rules": self.rules.name,
            "people": ", ".join(people) or "nobody",
            "machines": ", ".join([*gantry, *lanes, *self.machines]) or "none",
            "expectations": ", ".join(self.expect) or "none",
        }
        return html_table(rows.items())

    @classmethod
    def load(cls, source: str | Path, *, own_code: bool = True) -> Trial:
        """Return a built-in trial or the trial in a YAML file.

        Custom Python code that it names must be beside the file. It is imported when the trial is
        run.

        Parameters
        ----------
        source : str or Path
            Name of a built-in trial (see `builtin_trials`) or path of a file.
        own_code : bool, optional
            Whether the trial may use custom Python code.

        Raises
        ------
        TrialError, FloorplanError, bdi.ProgramError
            If the file, its floorplan or a program cannot be read or contains errors. All errors
            are reported together.
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
        """Return the trial in a text.

        Parameters
        ----------
        text : str
            YAML.
        file : str, optional
            Name of the text in messages.
        folder : str or Path, optional
            Folder of the files that it names.
        own_code : bool, optional
            Whether the trial may use custom Python code.

        Raises
        ------
        TrialError, FloorplanError, bdi.ProgramError
            If the text contains errors. See `load`.
        """
        from .building import build

        return build(cls, parse_yaml(text, file, TrialError), CodeFolder(Path(folder), own_code))

    def to_yaml(self, folder: str | Path = ".") -> str:
        """Return the text of a trial file.

        A floorplan that was not read from a file is included.

        Parameters
        ----------
        folder : str or Path, optional
            Folder of the file. Paths in it are relative to this folder.

        Raises
        ------
        ValueError
            If orders, a law or a program were not read from a file, if the floorplan is invalid, or
            if custom code is not in `folder` or above.
        """
        from .writing import to_yaml

        return to_yaml(self, Path(folder))

    def save(self, path: str | Path) -> None:
        """Write the trial to a YAML file.

        Parameters
        ----------
        path : str or Path
            File.

        Raises
        ------
        ValueError
            If the trial cannot be written. See `to_yaml`.
        """
        path = Path(path)
        write_whole(path, self.to_yaml(path.parent))

    def with_personality(self, personality: str | bdi.Program) -> Trial:
        """Return this trial with one personality for all people, without changes.

        Parameters
        ----------
        personality : str or bdi.Program
            Personality, as in `PersonEntry`.

        Raises
        ------
        TrialError
            If there is no personality of that name.
        bdi.ProgramError
            If the program contains errors.
        """
        from ..people.programs import load_program, modules_of

        for actions in dict.fromkeys(person.actions for person in self.people):
            modules = modules_of(actions, self.actions)
            load_program(personality, self.code_folder, modules)
        return self.with_people(lambda one: replace(one, personality=personality, changes=()))
