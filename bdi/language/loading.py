"""Loading of programs from files and texts: inclusion, namespaces and goal patterns.

The parser, and lark with it, is imported when the first text is read.

The patterns follow Hübner, Bordini and Wooldridge, "Programming declarative goals using plan
patterns" (DALT 2006). A pattern adds plans to those between its directives that make its goal
declarative: achieved when it is believed, and tried again after a failure.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias
from weakref import WeakValueDictionary

from ..errors import ProgramError, ProgramProblem
from .body import BodyFormula, Place, Test, Update
from .namespaces import NO_NAMESPACE, THIS, Namespace
from .operations import Conjunction, Negation, TriggerTerm
from .program import Belief, Clause, Directive, Goal, Plan, Program, Rule
from .terms import TRUE, Literal, Term, text
from .unification import unified


def read_clauses(source: str, file: str) -> tuple[tuple[Clause, ...], tuple[ProgramProblem, ...]]:
    """Return the clauses of a text in order, and the problems of invalid clauses."""
    from . import parser

    return parser.read_clauses(source, file)


def _parse_part(source: str, before: str = "") -> Any:
    from . import parser

    return parser.parse_part(source, before)


def _wrong_part(source: str, expected: str) -> ProgramError:
    return ProgramError([ProgramProblem(file=source, message=f"{expected} is expected")])


def parse_literal(source: str) -> Literal:
    """Return the literal in `source`, such as `gantry_detected(3)[source(percept)]`.

    Parameters
    ----------
    source : str
        Belief, goal or percept in AgentSpeak.

    Returns
    -------
    Literal
        The literal.

    Raises
    ------
    ProgramError
        If `source` is not one literal.

    Examples
    --------
    >>> bdi.parse_literal("at(station2)").functor
    'at'
    """
    return _literal(source)


_FACT = re.compile(
    r"([a-z]\w*)\( *(-?\d{1,12}(?:\.\d{1,12})?(?: *, *-?\d{1,12}(?:\.\d{1,12})?)*) *\)", re.ASCII
)
"""Literal whose arguments are decimal numbers, such as the places of many people."""


@lru_cache(maxsize=4096)
def _literal(source: str) -> Literal:
    # Cached because a trial reads each belief twice: in its check and for its agent.
    fact = _FACT.fullmatch(source)
    if fact and _is_functor(fact[1]):
        return Literal(fact[1], tuple(map(float, fact[2].split(","))))
    clause = _parse_part(source)
    if isinstance(clause, Belief):
        return clause.belief
    raise _wrong_part(source, "a literal")


@lru_cache(maxsize=256)
def _is_functor(name: str) -> bool:
    """Return whether a name can be the functor of a belief."""
    try:
        return isinstance(_parse_part(f"{name}(0)"), Belief)
    except ProgramError:
        return False


def parse_term(source: str) -> Term:
    """Return the term or formula in `source`. Raises `ProgramError` if it is not one term."""
    clause = _parse_part(source, "term :- ")
    if isinstance(clause, Rule):
        return clause.body
    raise _wrong_part(source, "a term")


def parse_trigger(source: str) -> TriggerTerm:
    """Return the event in `source`, such as `+work_completed(_)`."""
    clause = _parse_part(source)
    if isinstance(clause, Plan):
        return TriggerTerm(clause.trigger.sort, clause.trigger.literal)
    raise _wrong_part(source, "an event, as +b or +!g,")


def parse_plan(source: str) -> Plan:
    """Return the plan in `source`, with or without its full stop."""
    whole = source.rstrip()
    clause = _parse_part(whole[:-1] if whole.endswith(".") else whole)
    if isinstance(clause, Plan):
        return clause
    raise _wrong_part(source, "a plan")


Clauses: TypeAlias = list[Clause]
_Pattern: TypeAlias = Callable[[Directive, Sequence[Clause]], Clauses]


class WrongPatternError(Exception):
    """Invalid use of a goal pattern."""


def apply_pattern(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """Return the clauses of a pattern around `inner`.

    Raises `WrongPatternError` if the arguments of the pattern are invalid.
    """
    return PATTERNS[directive.name](directive, inner)


def _goal(directive: Directive, index: int = 0) -> Literal:
    goal = directive.args[index] if index < len(directive.args) else None
    if isinstance(goal, Literal):
        return goal
    raise WrongPatternError(f"argument {index + 1} of {directive.name} is a goal, as go(X)")


def _plan(source: str, place: Place) -> Plan:
    try:
        return replace(parse_plan(source), place=place)
    except ProgramError as error:
        raise WrongPatternError(str(error)) from None


def _achieves(clause: Clause, goal: Literal) -> bool:
    if not isinstance(clause, Plan) or clause.trigger.kind != "!":
        return False
    return unified(clause.trigger.literal, goal, {}) is not None


def _tests(plan: Plan) -> BodyFormula:
    return Test(plan.trigger.literal, plan.place)


def _declarative(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """Pattern dg(g): g is achieved when it is believed."""
    goal, place = _goal(directive), directive.place
    # First in the program, so that believed goals need no further plan.
    plans: Clauses = [
        _plan(f"+!{goal} : {goal}", place),
        _plan(f"+!{goal} : .intend({goal})", place),
    ]
    for clause in inner:
        if isinstance(clause, Plan) and _achieves(clause, goal):
            clause = replace(clause, body=(*clause.body, _tests(clause)))
        plans.append(clause)
    return [*plans, _plan(f"+{goal} <- .succeed_goal({goal})", place)]


def _backtracking(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """Pattern bdg(g): as dg(g), and g is tried again after a failure."""
    goal = _goal(directive)
    return [*_declarative(directive, inner), _plan(f"-!{goal} <- !{goal}", directive.place)]


def _exclusive(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """Pattern ebdg(g): as bdg(g), and no plan for g is tried twice."""
    goal, place = _goal(directive), directive.place
    plans: Clauses = [_plan(f"+!{goal} : {goal}", place)]
    number = 0
    for clause in inner:
        if isinstance(clause, Plan) and _achieves(clause, goal):
            number += 1
            # The plan records that it is tried before its first step, which may fail.
            tried = Literal("p__f", (float(number), goal))
            context: Term = Negation(tried)
            if clause.context != TRUE:
                context = Conjunction(context, clause.context)
            body = (Update("+", tried, clause.place), *clause.body, _tests(clause))
            clause = replace(clause, context=context, body=body)
        plans.append(clause)
    forget = f".abolish(p__f(_,{goal}))"
    return [
        *plans,
        _plan(f"-!{goal} <- !{goal}", place),
        _plan(f"+{goal} <- {forget}; .succeed_goal({goal})", place),
        _plan(f"-{goal} <- {forget}", place),
    ]


def _within(directive: Directive, inner: Sequence[Clause], pattern: str) -> Clauses:
    """Return the clauses of the pattern named by an argument, by default `pattern`."""
    goal = _goal(directive)
    chosen = directive.args[1] if len(directive.args) > 1 else Literal(pattern, (goal,))
    if not isinstance(chosen, Literal) or chosen.functor not in PATTERNS:
        raise WrongPatternError(f"argument 2 of {directive.name} is a pattern, as {pattern}(g)")
    return apply_pattern(replace(directive, name=chosen.functor, args=chosen.args), inner)


def _blind(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """Pattern bc(g, pattern): g is pursued forever."""
    goal = _goal(directive)
    return [*_within(directive, inner, "bdg"), _plan(f"+!{goal} <- !{goal}", directive.place)]


def _committed(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    blind = replace(directive, name="bc", args=directive.args[:1])
    return _blind(blind, inner)


def _single_minded(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """Pattern smc(g, f): g is pursued until f is believed."""
    goal, failed = _goal(directive), _goal(directive, 1)
    return [
        *_committed(directive, inner),
        _plan(f"+{failed} <- .fail_goal({goal})", directive.place),
    ]


def _relativised(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """Pattern rc(g, m): g is pursued as long as m is believed."""
    goal, motive = _goal(directive), _goal(directive, 1)
    return [
        *_committed(directive, inner),
        _plan(f"-{motive} <- .succeed_goal({goal})", directive.place),
    ]


def _open_minded(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """Pattern omc(g, f, m): g is pursued until f is believed or m is no longer believed."""
    goal, failed, motive = (_goal(directive, index) for index in range(3))
    return [
        *_committed(directive, inner),
        _plan(f"+{failed} <- .drop_intention({goal})", directive.place),
        _plan(f"-{motive} <- .succeed_goal({goal})", directive.place),
    ]


def _maintained(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """Pattern mg(g, pattern): g is believed initially, and pursued when it is not believed."""
    goal = _goal(directive)
    return [
        Belief(goal, directive.place),
        *_within(directive, inner, "bc"),
        _plan(f"-{goal} <- !{goal}", directive.place),
    ]


def _sequenced(directive: Directive, inner: Sequence[Clause]) -> Clauses:
    """Pattern sga("t", "c", g): each event t adopts g if c holds, one after another."""
    if len(directive.args) != 3 or not all(isinstance(arg, str) for arg in directive.args[:2]):
        raise WrongPatternError('sga takes an event, a context and a goal: sga("+b", "c", g)')
    goal, place = _goal(directive, 2), directive.place
    try:
        trigger = parse_trigger(str(directive.args[0]))
        context = text(parse_term(str(directive.args[1])))
    except ProgramError as error:
        raise WrongPatternError(str(error)) from None
    event = f"{trigger.sort}{trigger.literal}"
    return [
        _plan(f"{event} : not f__l(_) & {context} <- !f__g({goal})", place),
        _plan(f"{event} : f__l(_) & ({context}) <- +f__l({goal})", place),
        _plan(f"+!f__g({goal}) <- +f__l({goal}); !{goal}; -f__l({goal})", place),
        _plan(f"-!f__g({goal}) <- -f__l({goal})", place),
        _plan(f"-f__l({goal}) : f__l({goal}) <- !f__g({goal})", place),
    ]


PATTERNS: Mapping[str, _Pattern] = MappingProxyType(
    {
        "dg": _declarative,
        "bdg": _backtracking,
        "ebdg": _exclusive,
        "bc": _blind,
        "smc": _single_minded,
        "rc": _relativised,
        "omc": _open_minded,
        "mg": _maintained,
        "sga": _sequenced,
    }
)
"""Patterns by the names of their directives."""


MAX_TEXT = 4_000_000
"""Maximum length of a program in characters. Reading such a program takes about a minute."""

_HANDED_OVER = re.compile(r"/dev/(stdin|fd/\d+)|/proc/self/fd/\d+")
"""Files passed by a shell, as for `<(command)`. They are read although they are not regular."""

_TOO_LONG = f"is longer than the limit of {MAX_TEXT:,} characters"


INCLUDED_ONLY = ("group.asl", "patrol.asl")
"""Programs that are parts of others and not personalities."""


def programs() -> dict[str, Path]:
    """Return the files of the built-in personalities, by name.

    Returns
    -------
    dict of str to Path
        Files by name.
    """
    files = _built_in().items()
    return {name.removesuffix(".asl"): path for name, path in files if name not in INCLUDED_ONLY}


@cache
def _built_in() -> dict[str, Path]:
    """Return the programs in the package, by file name."""
    folder = Path(__file__).parents[1] / "personalities"
    return {path.name: path for path in sorted(folder.glob("*.asl"))}


def load(name: str | Path) -> Program:
    """Return a built-in personality or the program in a file.

    Parameters
    ----------
    name : str or Path
        Name of a personality (see `programs`) or path of a file.

    Returns
    -------
    Program
        The program.

    Raises
    ------
    ProgramError
        If the file cannot be read or contains errors.
    """
    file = _built_in().get(f"{name}.asl") if isinstance(name, str) else None
    return parse_file(name) if file is None else _load_built_in(file)


@cache
def _load_built_in(file: Path) -> Program:
    """Return a program of the package. Each is read once, because these files do not change."""
    return parse_file(file)


def parse_file(path: str | Path, *, namespace: str = "default") -> Program:
    """Read the program in a file.

    The files that it includes must be in its folder, in a folder below, or built in.

    Parameters
    ----------
    path : str or Path
        File.
    namespace : str, optional
        Namespace of its names.

    Returns
    -------
    Program
        The program.

    Raises
    ------
    ProgramError
        If the file cannot be read or contains errors. All errors are reported together.
    """
    path = Path(path)
    source = _read(path)
    if isinstance(source, ProgramProblem):
        raise ProgramError([source])
    return _parse(source, str(path), path.parent, namespace)


def parse(source: str, name: str = "<text>", *, folder: str | Path | None = None) -> Program:
    """Read a program from a text.

    Parameters
    ----------
    source : str
        Program in AgentSpeak.
    name : str, optional
        Name of the text in messages.
    folder : str or Path, optional
        Folder of the files that it includes. By default it can only include built-in files.

    Returns
    -------
    Program
        The program.

    Raises
    ------
    ProgramError
        If the text contains errors. All errors are reported together.

    Examples
    --------
    >>> program = bdi.parse("open(door1). !walk. +!walk : open(D) <- .print(D).")
    >>> len(program.plans)
    1
    """
    return _parse(source, name, None if folder is None else Path(folder))


def _parse(source: str, name: str, folder: Path | None, namespace: str = "default") -> Program:
    if len(source) > MAX_TEXT:
        raise ProgramError([ProgramProblem(file=name, message=_TOO_LONG)])
    within = NO_NAMESPACE if namespace == "default" else Namespace(namespace)
    clauses, problems = _read_all(source, name, folder, (), within)
    if problems:
        raise ProgramError(problems)
    # The clauses of a text are cached, so equal clauses mean the same program.
    key = (name, folder, tuple(map(id, clauses)))
    program = _READ.get(key)
    if program is None:
        program = _READ[key] = Program(
            source=name,
            beliefs=tuple(c for c in clauses if isinstance(c, Belief | Rule)),
            goals=tuple(c for c in clauses if isinstance(c, Goal)),
            plans=tuple(c for c in clauses if isinstance(c, Plan)),
            folder=folder,
        )
    return program


_READ: WeakValueDictionary[tuple[object, ...], Program] = WeakValueDictionary()
"""Programs in use by name, folder and clauses."""


def _read_all(
    source: str,
    file: str,
    folder: Path | None,
    including: tuple[str, ...],
    namespace: Namespace = NO_NAMESPACE,
) -> tuple[list[Clause], list[ProgramProblem]]:
    """Return the clauses of a text and its included files in order, and all problems."""
    clauses, wrong = read_clauses(source, file)
    reading = _FileReader(folder, (*including, file), namespace, "::" in source or THIS in source)
    expanded = reading.read(list(clauses))
    problems = [*wrong, *reading.problems]
    return expanded, sorted(problems, key=lambda p: (p.file != file, p.file, p.line, p.column))


class _FileReader:
    """Reader of one file, which carries out its directives."""

    def __init__(
        self,
        folder: Path | None,
        including: tuple[str, ...],
        namespace: Namespace,
        names_namespaces: bool,
    ) -> None:
        self.problems: list[ProgramProblem] = []
        self._folder = folder
        self._including = including
        self._namespace = namespace
        self._names_namespaces = names_namespaces or namespace is not NO_NAMESPACE

    def read(self, clauses: list[Clause]) -> list[Clause]:
        """Return the clauses, with those of their directives."""
        waiting = list(reversed(clauses))
        return self._block(waiting, None)

    def _block(self, waiting: list[Clause], opened: Directive | None) -> list[Clause]:
        """Take the clauses up to the end of a block or of the file."""
        found: list[Clause] = []
        while waiting:
            clause = waiting.pop()
            if not isinstance(clause, Directive):
                found.append(self._namespace.place(clause) if self._names_namespaces else clause)
            elif clause.name == "end" and not clause.opens:
                if opened is not None:
                    return found
                self._refuse(clause, "there is no { begin … } that { end } could close")
            elif clause.opens:
                found.extend(self._opened(clause, waiting))
            else:
                found.extend(self._carried_out(clause))
        if opened is not None:
            self._refuse(opened, f"{{ begin {opened.name} }} is not closed by {{ end }}")
        return found

    def _refuse(self, directive: Directive, message: str) -> None:
        self.problems.append(directive.place.problem(message))

    def _opened(self, directive: Directive, waiting: list[Clause]) -> list[Clause]:
        if directive.name == "namespace":
            outer = self._namespace
            self._namespace = self._named(directive) or outer
            inner = self._block(waiting, directive)
            self._namespace = Namespace(outer.name, self._namespace.local)
            return inner
        inner = self._block(waiting, directive)
        if directive.name not in PATTERNS:
            names = ", ".join(("namespace", *PATTERNS))
            self._refuse(directive, f"there is no {{ begin {directive.name} }}; there are {names}")
            return []
        try:
            return apply_pattern(directive, inner)
        except WrongPatternError as error:
            self._refuse(directive, str(error))
            return []

    def _named(self, directive: Directive) -> Namespace | None:
        """Return the namespace of a directive, if any."""
        names = [arg.functor for arg in directive.args if isinstance(arg, Literal) and arg.is_atom]
        if len(names) != len(directive.args) or not 1 <= len(names) <= 2:
            self._refuse(directive, "namespace takes a name, and local or global")
            return None
        kind = names[1] if len(names) > 1 else ""
        if kind not in ("", "local", "global"):
            self._refuse(directive, f"a namespace is local or global, not {kind}")
            return None
        name, local = names[0], dict(self._namespace.local)
        self._names_namespaces = True
        if kind == "local":
            # Each declaration has a unique name, because a local namespace belongs to its file.
            place = directive.place
            local.setdefault(name, f"#{Path(place.file).stem}{self._namespace.name}{name}")
        elif kind == "global":
            local.pop(name, None)
        return Namespace(local.get(name, name), local)

    def _carried_out(self, directive: Directive) -> list[Clause]:
        if directive.name == "namespace":
            declared = self._named(directive)
            if declared is not None:
                self._namespace = Namespace(self._namespace.name, declared.local)
            return []
        if directive.name == "register_function":
            return []
        opened = _open_included(directive, self._folder, self._including)
        if isinstance(opened, str):
            self._refuse(directive, opened)
            return []
        namespace = self._namespace
        if len(directive.args) > 1:
            target = directive.args[1]
            assert isinstance(target, Literal)  # as `_open_included` has checked
            namespace = Namespace(namespace.resolved(target.functor))
        more, wrong = _read_all(*opened, self._folder, self._including, namespace)
        self.problems.extend(wrong)
        return more


def _open_included(
    directive: Directive, folder: Path | None, including: tuple[str, ...]
) -> tuple[str, str] | str:
    """Return the text and the path of an included file, or the reason why there is none."""
    if directive.name != "include":
        known = "those there are: include, namespace, register_function and { begin … }"
        return f"there is no directive '{directive.name}'; {known}"
    name, *rest = directive.args or ("",)
    is_placed = all(isinstance(arg, Literal) and arg.is_atom for arg in rest)
    if not isinstance(name, str) or not name or len(rest) > 1 or not is_placed:
        return 'include takes the name of a file: { include("patrol.asl") }, and a namespace'
    path = find_included(name, folder)
    if isinstance(path, str):
        return path
    text = _read(path)
    if isinstance(text, ProgramProblem):
        return f"{path} {text.message}"
    if str(path) in including:
        return f"{name} includes itself"
    return text, str(path)


def find_included(name: str, folder: Path | None) -> Path | str:
    """Return the file that an inclusion names, or the reason why there is none."""
    if folder is not None:
        inside = folder.resolve()
        try:
            path = (inside / name).resolve()
            if not path.is_relative_to(inside):
                return f"'{name}' is outside the program's folder {folder}"
            if path.is_file():
                return path
        except (OSError, ValueError):
            return f"'{name}' is not a file name"
    if name in _built_in():
        return _built_in()[name]
    where = "and none is built in" if folder is None else f"in {folder}, and none is built in"
    return f"there is no file '{name}' {where}"


def _read(path: Path) -> str | ProgramProblem:
    """Return the text of a file that is regular or passed by a shell."""
    try:
        if not (path.is_file() or _HANDED_OVER.fullmatch(str(path))) and path.exists():
            return ProgramProblem(file=str(path), message="is no regular file")
        with path.open(encoding="utf-8") as file:
            text = file.read(MAX_TEXT + 1)
    except FileNotFoundError:
        return ProgramProblem(file=str(path), message="there is no such file")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        return ProgramProblem(file=str(path), message=f"cannot be read: {reason}")
    return ProgramProblem(file=str(path), message=_TOO_LONG) if len(text) > MAX_TEXT else text
