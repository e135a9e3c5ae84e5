"""The keys of a gantry in a trial file."""

from typing import Annotated

from pydantic import model_validator

from floorplan import Flag, NotNegative, Positive, Range, UserError, whole

from ...core.keys import Keys, Pose
from ...core.scenario import GantryEntry, Job
from ...core.workload import Drop


class _Job(Keys):
    move: Pose | None = None
    wait: Positive | None = None
    pick: str | None = None
    place: str | None = None
    part: str = "part"
    submit: str | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> "_Job":
        given = self.model_fields_set - {"part"}
        if given not in ({"move"}, {"wait"}, {"pick", "place"}, {"submit"}):
            raise UserError("a job is one of move, wait, pick with place, or submit")
        return self

    def value(self) -> Job:
        if self.move is not None:
            return Job("move", target=self.move)
        if self.wait is not None:
            return Job("wait", seconds=self.wait)
        if self.submit is not None:
            return Job("submit", order=self.submit)
        return Job("pick_place", pick=self.pick or "", place=self.place or "", part=self.part)


class _Drop(Keys):
    part: str = "part"
    after: Annotated[int, whole(0)] = 0
    delay: NotNegative = 0.0

    def value(self) -> Drop:
        return Drop(self.part, self.after, self.delay)


class GantryKeys(Keys):
    """The gantry of the floor."""

    controller: str = "parked"
    at: Pose | None = None
    jobs: list[_Job] = []
    repeat: Flag = False
    drops: list[_Drop] = []

    def value(self) -> GantryEntry:
        """Return the gantry, but for ranges of its own."""
        fields = self.fields()
        return GantryEntry(**{name: fields[name] for name in GantryKeys.model_fields})


class BridgeKeys(GantryKeys):
    """One more gantry on the rails of the floor, within ranges of its own."""

    at: Pose
    x: Range | None = None
    y: Range | None = None
