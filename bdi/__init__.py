"""What a person wants: an AgentSpeak interpreter in the dialect of Jason.

```python
program = bdi.parse_file("human.asl")
agent = bdi.Agent(program, beliefs=["helpful"], act=my_action)
agent.add_percept("human_start")
agent.advance(12.5)
```
"""

from .agent import PENDING, Agent, Pending
from .beliefs import LiveBeliefs
from .errors import EndlessProgramError, Problem, ProgramError
from .history import Entry, History
from .intentions import Intention
from .internal_actions import Call, InternalAction, InternalActions
from .loading import load, parse, parse_file, programs
from .parser import parse_literal, parse_term
from .program import Belief, Goal, Plan, Program, Rule
from .society import Message, Society
from .terms import Literal, Term, Var, text

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
    "Rule",
    "Society",
    "Term",
    "Var",
    "load",
    "parse",
    "parse_file",
    "parse_literal",
    "parse_term",
    "programs",
    "text",
]
