"""A kind of machine that the library does not know: a tugger train on a closed course."""

from dataclasses import dataclass

import navigation
import sim
from sim.core.clock import Alarm, Turn


@dataclass(frozen=True)
class Tugger(sim.MachineModel):
    """What a trial says of a tugger: the corners of its course (metres), and how it drives."""

    course: tuple[tuple[float, float], ...]
    speed: float = 1.2
    acceleration: float = 0.6
    stop: float = 10.0
    """Seconds that it stands at the first corner after each round."""

    def shape(self, name, plan):
        """What everybody else knows of it."""
        return sim.MachineShape(
            name=name,
            kind="tugger",
            category="vehicle",
            length=1.8,
            width=0.9,
            top=1.4,
            top_speed=self.speed,
            course=(*self.course, self.course[0]),
        )

    def make(self, name, stage):
        """The tugger itself."""
        return Train(self, name, stage)

    def faults(self, plan, vehicles):
        """What a file may get wrong beyond the types of its keys."""
        if len(self.course) < 3:
            yield "a closed course has at least three corners", ("course",)


class Train(sim.Machine):
    """A tugger under way: round after round, with a stop in between."""

    def __init__(self, model, name, stage):
        self.shape = model.shape(name, stage.floorplan)
        at = navigation.standing(model.course[0], start=stage.clock.now)
        self.body = sim.Body(stage.clock, name, "tugger", at)
        self.rounds = 0
        self._model, self._stage = model, stage
        self._left = self.shape.course
        self._held = False
        self._rest = Alarm(stage.clock, self._stands, Turn.MOTION_ENDS)
        self._next = Alarm(stage.clock, self._drive, Turn.MOTION_ENDS)

    def begin(self):
        self._drive()

    def hold(self, stands):
        """A protective stop, where the rules ask for one."""
        self._held = stands
        self._next.set(None)
        if stands:
            now, a = self._stage.clock.now, self._model.acceleration
            brake = navigation.stop_walking(self.body.motion, now, max_acceleration=a)
            ahead = navigation.remaining_path(self.body.motion, now)
            self._left = (brake.state(brake.end).at, *ahead[1:])
            self._follow(brake)
        else:
            self._drive()

    def figures(self, motion, now):
        return {"rounds": self.rounds}

    def _drive(self):
        now, model = self._stage.clock.now, self._model
        self._follow(
            navigation.walk(
                self._left, now, max_speed=model.speed, max_acceleration=model.acceleration
            )
        )

    def _follow(self, motion):
        self.body.follow(motion)
        self._rest.set(motion.end)

    def _stands(self):
        if not self._held:
            self.rounds += 1
            self._left = self.shape.course
            self._next.set(self._stage.clock.now + self._model.stop)
        self._stage.came_to_rest(self)
