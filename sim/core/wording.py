"""Wording of numbers, units, intervals and lists in pages, tables and messages."""

from __future__ import annotations

import math
from collections.abc import Sequence


def minus(figures: str) -> str:
    """Return figures with minus signs instead of hyphens."""
    return figures.replace("-", "−")


def figure(value: float | None, digits: int | None = None) -> str:
    """Return a number with three or four significant digits, or with `digits` decimals."""
    if value is None or not math.isfinite(value):
        return "–"
    if digits is None:
        digits = 0 if value == round(value) else digits_after(abs(value))
    return minus(f"{round(value, digits) + 0.0:,.{digits}f}")  # no negative zero


def digits_after(size: float) -> int:
    """Return the number of decimals for a value of this size."""
    return 0 if size >= 1000 else 1 if size >= 100 else 2 if size >= 1 else 3


def interval(low: float, high: float, digits: int | None = None) -> str:
    """Return an interval of figures."""
    return f"{figure(low, digits)} … {figure(high, digits)}"


def signed(value: float) -> str:
    """Return a difference with two decimals and its sign."""
    return "0.00" if round(value, 2) == 0 else minus(f"{value:+.2f}")


def significant(value: float) -> str:
    """Return a number with its significant digits, at most six."""
    return f"{value:.6g}"


def trimmed(value: float) -> str:
    """Return a number with at most three decimals."""
    return f"{value:.3f}".rstrip("0").rstrip(".")


def to_millimetres(length: float) -> str:
    """Return a length or a margin (m) to a millimetre."""
    return f"{round(length, 3) + 0.0:.3f}"  # no negative zero


def percent(part: float, whole: float = 1.0, digits: int = 0) -> str:
    """Return a part of a whole in percent."""
    return f"{100 * part / whole:.{digits}f} %"


def clock(seconds: float) -> str:
    """Return a duration as h:mm:ss."""
    whole = round(seconds)
    return f"{whole // 3600}:{whole % 3600 // 60:02}:{whole % 60:02}"


def times(instants: Sequence[float], most: int) -> str:
    """Return times (s), the first `most` of them, and the number of the others."""
    shown = ", ".join(f"{t:.3f} s" for t in instants[:most])
    return shown + (f" and {len(instants) - most} more" if len(instants) > most else "")


def listed(names: Sequence[str]) -> str:
    """Return names in a row. More than three are abbreviated, with their number."""
    if len(names) <= 3:
        return ", ".join(names)
    return f"{names[0]} … {names[-1]} ({len(names)})"


def counted(count: int, noun: str) -> str:
    """Return a number with its noun."""
    if noun == "person":
        return "1 person" if count == 1 else f"{count:,} people"
    plural = f"{noun[:-1]}ies" if noun.endswith("y") and noun[-2] not in "aeiou" else f"{noun}s"
    return f"{count:,} {noun if count == 1 else plural}"


def distinguished(distance: float, required: float) -> tuple[str, str]:
    """Return a distance and the required distance (m) with enough digits to differ.

    A violation begins where the two are equal. Recorded times are rounded, so that a difference
    below a millimetre means that the distance is just under the required one.
    """
    for digits in (2, 3):
        shown = f"{distance:.{digits}f}", f"{required:.{digits}f}"
        if shown[0] != shown[1]:
            return shown
    return ("just under " if distance < required else "") + f"{distance:.2f}", f"{required:.2f}"
