"""People and vehicles on given courses, with the table of their motions, for tests of reactions."""

from types import SimpleNamespace

from floorplan import Human
from navigation import standing
from navigation.walking import motion_along
from sim.core.body import Body
from sim.core.clock import Alarm, Clock, Turn
from sim.people.crowd.commitments import Commitments
from sim.people.crowd.interrupt import Interruptions
from sim.people.crowd.parameters import Manners
from sim.people.crowd.speed_zones import SpeedZones
from sim.people.crowd.step_aside import StepsAside
from sim.people.crowd.traveller import Traveller


class Walkers:
    """People who walk along the courses of a test, with their reactions."""

    def __init__(self):
        self.clock = Clock()
        self.table = Commitments()
        self.people = {}
        self.decided = []
        """People who replanned."""
        self.committed = {}
        """Motions to which people were committed."""
        self.interruptions = Interruptions(
            SimpleNamespace(clock=self.clock),
            self.table,
            self._no_ground,
            self.decided.append,
            self._commit,
        )
        self.steps_aside = StepsAside(
            self.clock,
            self.table,
            self.people,
            self._no_ground,
            self.decided.append,
            self._commit,
            self.interruptions,
            lambda me, motion: False,
        )

    def walker(self, *course, speed=1.0, goal=True, **keys):
        """Add a person at the first place of a course, who walks along the rest."""
        me = Traveller(
            len(self.table.people),
            Body(self.clock, f"p{len(self.table.people)}", "human", standing(course[0])),
            Human(max_speed=2.0, max_acceleration=1.0),
            Manners(),
            None,
            SpeedZones((), ""),
            **keys,
        )
        me.top_speed = speed
        me.goal = course[-1] if goal else None
        me.arriving = Alarm(self.clock, lambda: None, Turn.MOTION_ENDS)
        me.stepping = Alarm(self.clock, lambda: self.steps_aside.step_aside(me), Turn.MOTION_ENDS)
        if len(course) > 1:
            self.walk(me, *course)
        self.table.put(me)
        if not me.is_vehicle:
            self.people[me] = None
        return me

    def walk(self, me, *course):
        """Start the walk of a standing person along a course."""
        draft = me.draft(course, self.clock.now)
        me.follow(motion_along(draft, 0.0), draft)

    def vehicle(self, *course, speed=1.0):
        """Add a vehicle of the size of a person, which drives along a course."""
        return self.walker(*course, speed=speed, recorded=True, is_vehicle=True)

    def until(self, t):
        """Run until a time (s)."""
        self.clock.run(until=t)

    def _commit(self, me, motion, ahead):
        self.committed[me] = motion
        me.follow(motion, ahead)
        self.table.put(me)

    def _no_ground(self, me):
        raise AssertionError(f"{me} looks for a place")
