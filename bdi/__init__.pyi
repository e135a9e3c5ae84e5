"""The public names of `bdi`, each loaded with its module when it is first used."""

from .actions import InternalActions
from .agent import Agent
from .errors import EndlessProgramError, ProgramError, ProgramProblem
from .language.loading import load, parse, parse_file, parse_literal, programs
from .language.program import Belief, Goal, Plan, Program, Rule
from .language.terms import Literal, Term, Var
from .lint import doubts
from .reasoning.circumstance import PENDING, Refused
from .reasoning.execution import Call
from .reasoning.state import AgentSettings, Entry
from .society import Message, Society

__all__ = [
    "PENDING",
    "Agent",
    "AgentSettings",
    "Belief",
    "Call",
    "EndlessProgramError",
    "Entry",
    "Goal",
    "InternalActions",
    "Literal",
    "Message",
    "Plan",
    "Program",
    "ProgramError",
    "ProgramProblem",
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
    "programs",
]
