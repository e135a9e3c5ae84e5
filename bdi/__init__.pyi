"""The public names of `bdi`, each loaded with its module when it is first used."""

from .actions import InternalActions as InternalActions
from .agent import Agent as Agent
from .errors import (
    EndlessProgramError as EndlessProgramError,
    ProgramError as ProgramError,
    ProgramProblem as ProgramProblem,
)
from .language.loading import (
    load as load,
    parse as parse,
    parse_file as parse_file,
    parse_literal as parse_literal,
    programs as programs,
)
from .language.program import (
    Belief as Belief,
    Goal as Goal,
    Plan as Plan,
    Program as Program,
    Rule as Rule,
)
from .language.terms import Literal as Literal, Term as Term, Var as Var
from .lint import doubts as doubts
from .reasoning.circumstance import PENDING as PENDING, Refused as Refused
from .reasoning.execution import Call as Call
from .reasoning.state import Entry as Entry
from .society import Message as Message, Society as Society
