"""Arithmetic as Jason does it: on doubles, with the corner cases of Java."""

from __future__ import annotations

import math
import operator
import statistics
from collections.abc import Callable, Mapping
from types import MappingProxyType

from .terms import Cons, Nil, Term

NAN = math.nan


def _divide(x: float, y: float) -> float:
    if y == 0.0:
        if x == 0.0 or math.isnan(x):
            return NAN
        return math.copysign(math.inf, x) * math.copysign(1.0, y)
    return x / y


def _to_int32(x: float) -> int:
    if math.isnan(x):
        return 0
    # Java's conversion to int: beyond its range the nearest there is, and towards zero.
    return int(max(-(2.0**31), min(2.0**31 - 1, x)))


def _integer_divide(x: float, y: float) -> float:
    divisor = _to_int32(y)
    if divisor == 0:
        return NAN
    # Towards zero, as Java divides; Python would round down.
    quotient = abs(_to_int32(x)) // abs(divisor)
    return float(quotient if (x < 0) == (y < 0) else -quotient)


def _modulo(x: float, y: float) -> float:
    # Java's % has the sign of the first operand, as `fmod` has; Python's that of the second.
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
        "+": operator.add,
        "-": operator.sub,
        "*": operator.mul,
        "/": _divide,
        "div": _integer_divide,
        "mod": _modulo,
        "**": _power,
    }
)


def _round(x: float) -> float:
    """Round halves up, as Java's `Math.round`."""
    return x if math.isinf(x) or math.isnan(x) else float(math.floor(x + 0.5))


def _logarithm(x: float) -> float:
    return -math.inf if x == 0.0 else math.log(x)


_OF_A_NUMBER: Mapping[str, Callable[[float], float]] = MappingProxyType(
    {
        "+": operator.pos,
        "-": operator.neg,
        "math.abs": abs,
        "math.acos": math.acos,
        "math.asin": math.asin,
        "math.atan": math.atan,
        "math.ceil": math.ceil,
        "math.cos": math.cos,
        "math.floor": math.floor,
        "math.log": _logarithm,
        "math.round": _round,
        "math.sin": math.sin,
        "math.sqrt": math.sqrt,
        "math.tan": math.tan,
    }
)

#: Functions of a list of numbers; `math.max` and `math.min` take two numbers as well.
_OF_NUMBERS: Mapping[str, Callable[[list[float]], float]] = MappingProxyType(
    {
        "math.average": statistics.fmean,
        "math.max": max,
        "math.mean": statistics.fmean,
        "math.median": statistics.median,
        "math.min": min,
        "math.std_dev": statistics.stdev,
        "math.sum": math.fsum,
    }
)

_CONSTANTS: Mapping[str, float] = MappingProxyType({"math.e": math.e, "math.pi": math.pi})

#: Functions that depend on the run, its random numbers and its time, by their arities.
RUN_FUNCTIONS: Mapping[str, tuple[int, ...]] = MappingProxyType(
    {"math.random": (0, 1), "system.time": (0,), ".count": (1,)}
)


def is_function(name: str, arity: int) -> bool:
    """Return True if `name` is an arithmetic function with that many arguments."""
    if name in RUN_FUNCTIONS:
        return arity in RUN_FUNCTIONS[name]
    if name in _CONSTANTS:
        return arity == 0
    if arity == 2:
        return name in ("math.max", "math.min")
    return arity == 1 and (name in _OF_A_NUMBER or name in _OF_NUMBERS or name == ".length")


def apply_function(
    name: str, args: tuple[Term, ...], calculate: Callable[..., float] | None = None
) -> float:
    """Return the value of a function of ground arguments; NaN if it is not defined for them.

    `calculate` is set for one of RUN_FUNCTIONS and of the user's own. One of these that can't take
    numbers at all is wrong: its `TypeError` is raised.
    """
    try:
        if name in _OF_NUMBERS:
            numbers = _numbers(args)
            if name == "math.sum" and len(args) == 1 and isinstance(args[0], Nil):
                return 0.0
            return float(_OF_NUMBERS[name](numbers)) if numbers else NAN
        if name == ".length":
            return float(len(args[0]))  # type: ignore[arg-type]
        if name in _CONSTANTS:
            return _CONSTANTS[name]
        if calculate is not None:
            return float(calculate(*args))
        function: Callable[..., float] | None = _OF_A_NUMBER.get(name)
        if function is None or not all(isinstance(arg, float) for arg in args):
            return NAN
        return float(function(*args))
    except TypeError:
        if calculate is not None and all(isinstance(arg, float) for arg in args):
            raise
        return NAN
    except (ValueError, OverflowError):
        return NAN


def _numbers(args: tuple[Term, ...]) -> list[float]:
    """Return the numbers of a list, which has only such, or those among the arguments."""
    values = args[0]
    if len(args) > 1 or not isinstance(values, Nil | Cons):
        return [arg for arg in args if isinstance(arg, float)]
    numbers = [value for value in values if isinstance(value, float)]
    return numbers if len(numbers) == len(values) else []
