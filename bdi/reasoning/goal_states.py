"""States of goals: the events `^!g[state(S)[reason(R)]]` for plans that watch over other goals."""

from __future__ import annotations

from ..language.order import with_more_annots
from ..language.terms import Literal, Term
from .circumstance import Circumstance
from .intentions import Event, Intention
from .plans import PlanLibrary


class GoalStates:
    """Raises an event when a goal comes into another state: at the beginning of the next cycle.

    The states are pending, executing, waiting, suspended, resumed, failed, achieved, dropped and
    finished. An event comes before all others, and only if there is a plan for it.
    """

    def __init__(self, circumstance: Circumstance, plans: PlanLibrary) -> None:
        self._circumstance = circumstance
        self._plans = plans
        self._changes: list[Event] = []

    @property
    def has_changes(self) -> bool:
        """True if goals have changed since the last cycle."""
        return bool(self._changes)

    def note(self, state: str, sort: str, goal: Literal, reason: Term | None = None) -> None:
        """Note that a goal is in another state; `sort` is that of its event, `+!` or `+?`."""
        why = Literal("reason", ("" if reason is None else reason,))
        annot = Literal("state", (Literal(state),), (why,))
        self._changes.append(Event("^" + sort[1:], with_more_annots(goal, annot)))

    def note_top(self, state: str, intention: Intention, reason: Term | None = None) -> None:
        """Note the state of the goal for which an intention carries out a plan."""
        if intention.stack and intention.top.sort in ("+!", "+?"):
            self.note(state, intention.top.sort, intention.top.literal, reason)

    def note_all(self, state: str, intention: Intention, *, but: Literal | None = None) -> None:
        """Note that all goals of an intention have ended, but one that is noted already."""
        for means in intention.downwards():
            if means.sort in ("+!", "+?") and means.literal is not but:
                self.note(state, means.sort, means.literal)
                self.note("finished", means.sort, means.literal)

    def post(self) -> None:
        """Post the events of the goals that have changed."""
        changes, self._changes = self._changes, []
        for event in changes:
            if self._plans.candidates(event.sort, event.literal):
                self._circumstance.post_state(event)
