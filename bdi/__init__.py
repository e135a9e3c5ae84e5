"""Interpreter of AgentSpeak in the dialect of Jason: the minds of people.

```python
program = bdi.parse_file("human.asl")
agent = bdi.Agent(program, beliefs=["helpful"], act=my_action)
agent.add_percept("human_start")
agent.advance(12.5)
```
"""

from .agent import Agent
from .errors import EndlessProgramError, Problem, ProgramError
from .language.loading import load, parse, parse_file, programs
from .language.program import Belief, Goal, Plan, Program, Rule
from .language.terms import Literal, Term, Var, text
from .language.texts import parse_literal, parse_term
from .lint import doubts
from .reasoning.actions import InternalAction, InternalActions
from .reasoning.beliefs import LiveBeliefs
from .reasoning.calls import Call
from .reasoning.circumstance import PENDING, Pending, Refused
from .reasoning.history import Entry, History
from .reasoning.intentions import Intention
from .reasoning.society import Message, Society

__all__ = [
    "PENDING",
    "Agent",
    "Belief",
    "Call",
    "EndlessProgramError",
    "Entry",
    "Goal",
    "History",
    "Intention",
    "InternalAction",
    "InternalActions",
    "Literal",
    "LiveBeliefs",
    "Message",
    "Pending",
    "Plan",
    "Problem",
    "Program",
    "ProgramError",
    "Refused",
    "Rule",
    "Society",
    "Term",
    "Var",
    "doubts",
    "load",
    "parse",
    "parse_file",
    "parse_literal",
    "parse_term",
    "programs",
    "text",
]
