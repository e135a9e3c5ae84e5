"""Arithmetic as Jason does it: on doubles, with Java's corner cases."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Mapping
from types import MappingProxyType

from .terms import Cons, Nil, Term, text

NAN = float("nan")


def _divide(x: float, y: float) -> float:
    if y == 0.0:
        if x == 0.0 or math.isnan(x):
            return NAN
        return math.copysign(math.inf, x) * math.copysign(1.0, y)
    return x / y


def _to_int32(x: float) -> int:
    if math.isnan(x):
        return 0
    return int(max(-(2.0**31), min(2.0**31 - 1, x)))


def _integer_divide(x: float, y: float) -> float:
    divisor = _to_int32(y)
    if divisor == 0:
        return NAN
    quotient = abs(_to_int32(x)) // abs(divisor)
    return float(quotient if (x < 0) == (y < 0) else -quotient)


def _modulo(x: float, y: float) -> float:
    return NAN if y == 0.0 or math.isinf(x) else math.fmod(x, y)


def _power(x: float, y: float) -> float:
    try:
        return math.pow(x, y)
    except ValueError:
        return math.inf if x == 0.0 else NAN
    except OverflowError:
        return -math.inf if x < 0 and y % 2 == 1 else math.inf


OPERATORS: Mapping[str, Callable[[float, float], float]] = MappingProxyType(
    {
        "+": lambda x, y: x + y,
        "-": lambda x, y: x - y,
        "*": lambda x, y: x * y,
        "/": _divide,
        "div": _integer_divide,
        "mod": _modulo,
        "**": _power,
    }
)


def _round(x: float) -> float:
    """Halves go up, as in Java's `Math.round`."""
    return x if math.isinf(x) or math.isnan(x) else float(math.floor(x + 0.5))


def _real(function: Callable[[float], float]) -> Callable[[float], float]:
    """A real function that is NaN where Python's raises."""

    def guarded(x: float) -> float:
        try:
            return float(function(x))
        except (ValueError, OverflowError):
            return NAN

    return guarded


def _logarithm(x: float) -> float:
    if x == 0.0:
        return -math.inf
    return NAN if x < 0 or math.isnan(x) else math.log(x)


def _numbers(values: Term) -> list[float]:
    if not isinstance(values, Nil | Cons):
        raise TypeError(f"a list of numbers is expected, not {text(values)}")
    numbers = [value for value in values if isinstance(value, float)]
    if len(numbers) != len(values):
        raise TypeError(f"a list of numbers is expected, not {values}")
    return numbers


def _of_numbers(function: Callable[[list[float]], float]) -> Callable[..., float]:
    """A function of one list, or of the numbers themselves."""

    def applied(*args: Term) -> float:
        if len(args) == 1 and isinstance(args[0], Nil | Cons):
            numbers = _numbers(args[0])
        else:
            numbers = [arg for arg in args if isinstance(arg, float)]
        return float(function(numbers)) if numbers else NAN

    return applied


def _length(value: Term) -> float:
    return float(len(value)) if isinstance(value, str | Nil | Cons) else NAN


#: Functions of a formula, by name, with the numbers of arguments they take.
#: `math.random` and `system.time` belong to the run and are added by it.
FUNCTIONS: Mapping[str, tuple[Callable[..., float], frozenset[int]]] = MappingProxyType(
    {
        "math.abs": (abs, frozenset({1})),
        "math.acos": (_real(math.acos), frozenset({1})),
        "math.asin": (_real(math.asin), frozenset({1})),
        "math.atan": (_real(math.atan), frozenset({1})),
        "math.average": (_of_numbers(statistics.fmean), frozenset({1})),
        "math.ceil": (lambda x: float(math.ceil(x)), frozenset({1})),
        "math.cos": (_real(math.cos), frozenset({1})),
        "math.e": (lambda: math.e, frozenset({0})),
        "math.floor": (lambda x: float(math.floor(x)), frozenset({1})),
        "math.log": (_logarithm, frozenset({1})),
        "math.max": (_of_numbers(max), frozenset({1, 2})),
        "math.mean": (_of_numbers(statistics.fmean), frozenset({1})),
        "math.median": (_of_numbers(statistics.median), frozenset({1})),
        "math.min": (_of_numbers(min), frozenset({1, 2})),
        "math.pi": (lambda: math.pi, frozenset({0})),
        "math.round": (_round, frozenset({1})),
        "math.sin": (_real(math.sin), frozenset({1})),
        "math.sqrt": (_real(math.sqrt), frozenset({1})),
        "math.std_dev": (_of_numbers(statistics.pstdev), frozenset({1})),
        "math.sum": (_of_numbers(math.fsum), frozenset({1})),
        "math.tan": (_real(math.tan), frozenset({1})),
        ".length": (_length, frozenset({1})),
    }
)

#: Functions whose value depends on the run: its random numbers, its time.
RUN_FUNCTIONS: Mapping[str, frozenset[int]] = MappingProxyType(
    {"math.random": frozenset({0, 1}), "system.time": frozenset({0})}
)


def is_function(name: str, arity: int) -> bool:
    if name in RUN_FUNCTIONS:
        return arity in RUN_FUNCTIONS[name]
    return name in FUNCTIONS and arity in FUNCTIONS[name][1]


#: Functions that take a list or a string.
_TAKE_ANYTHING = frozenset(
    {
        "math.average",
        "math.max",
        "math.mean",
        "math.median",
        "math.min",
        "math.std_dev",
        "math.sum",
        ".length",
    }
)


def apply_function(
    name: str, args: tuple[Term, ...], calculate: Callable[..., float] | None = None
) -> float:
    """The value of a function of ground arguments; NaN for arguments of the wrong kind."""
    if calculate is None:
        if name not in FUNCTIONS:
            return NAN
        calculate, _ = FUNCTIONS[name]
    if name not in _TAKE_ANYTHING and not all(isinstance(arg, float) for arg in args):
        return NAN
    try:
        return float(calculate(*args))
    except (TypeError, ValueError, OverflowError):
        return NAN
