"""Separation laws in print: their formulas, terms and sources."""

from __future__ import annotations

import math
from dataclasses import dataclass

from markupsafe import Markup, escape

from navigation import AnyLaw, ApproachLaw, FixedDistance, IntegralLaw, Scaled, SeparationLaw

from ...safety.own_law import OwnLaw

_T1, _T2 = Markup("T<sub>1</sub>"), Markup("T<sub>2</sub>")
_HUMAN, _ROBOT = Markup("v<sub>H</sub>"), Markup("v<sub>R</sub>")


@dataclass(frozen=True)
class LawSheet:
    """A law: its name and source, its formula, and each term: symbol, value, meaning."""

    name: str
    formula: Markup
    terms: tuple[tuple[Markup, str, str], ...]


def law_sheet(law: AnyLaw) -> LawSheet:
    """Return what there is to say about a law."""
    match law:
        case SeparationLaw():
            return LawSheet(
                "ISO/TS 15066:2016, clause 5.5.4, linear form (Marvel and Norcross 2017)",
                Markup("S = {} ({} + {}) + {} {} + B + δ").format(_HUMAN, _T1, _T2, _ROBOT, _T1),
                (
                    *_times(law.t1, law.t2),
                    (Markup("B"), _metres(law.stopping), "distance covered while stopping"),
                    (Markup("δ"), _metres(law.intrusion), "intrusion allowance"),
                    *_SPEEDS,
                ),
            )
        case IntegralLaw():
            stopping = (
                Markup("the way of a speed that falls evenly to 0 within {}").format(_T2)
                if law.stopping is None
                else _metres(law.stopping)
            )
            return LawSheet(
                "ISO/TS 15066:2016, clause 5.5.4.2.3, integral form",
                Markup(
                    "S = ∫<sub>0</sub><sup>{0}+{1}</sup> {2} dt + ∫<sub>0</sub><sup>{0}</sup>"
                    " {3} dt + S<sub>S</sub> + C + Z<sub>D</sub> + Z<sub>R</sub>"
                ).format(_T1, _T2, _HUMAN, _ROBOT),
                (
                    *_times(law.t1, law.t2),
                    (Markup("S<sub>S</sub>"), stopping, "way of the machine while it stops"),
                    (Markup("C"), _metres(law.intrusion), "intrusion distance"),
                    (
                        Markup("Z<sub>D</sub>"),
                        _metres(law.human_uncertainty),
                        "uncertainty of where the person is",
                    ),
                    (
                        Markup("Z<sub>R</sub>"),
                        _metres(law.robot_uncertainty),
                        "uncertainty of where the machine is",
                    ),
                    *_SPEEDS,
                ),
            )
        case ApproachLaw():
            return LawSheet(
                "ISO 13855:2010, clause 5",
                Markup("S = K T + C"),
                (
                    (Markup("K"), f"{law.speed:g} m/s", "speed of approach of a person"),
                    (Markup("T"), f"{law.time:g} s", "from sensing to the end of the motion"),
                    (Markup("C"), _metres(law.intrusion), "intrusion distance"),
                ),
            )
        case FixedDistance():
            return LawSheet(
                "a fixed distance",
                Markup("S = {}").format(_metres(law.metres)),
                (),
            )
        case Scaled():
            inner = law_sheet(law.law)
            cap = "" if law.cap == math.inf else f", of S at most {_metres(law.cap)}"
            return LawSheet(
                inner.name,
                Markup("{} × S{}, with {}").format(f"{law.factor:g}", cap, inner.formula),
                inner.terms,
            )
        case OwnLaw():
            terms = tuple((escape(k), plain_value(v), "") for k, v in law.terms.items())
            return LawSheet(f"own code: {law.name}", Markup("as programmed"), terms)
    name = str(getattr(law, "name", "") or type(law).__qualname__)
    return LawSheet(f"own code: {name}", Markup("as programmed"), ())


def plain_value(value: object) -> str:
    """Return a term of a law of one's own."""
    return f"{value:g}" if isinstance(value, float) else str(value)


_SPEEDS = (
    (_HUMAN, "", "speed of the person at the instant"),
    (_ROBOT, "", "speed of the machine at the instant"),
)


def _times(t1: float, t2: float) -> tuple[tuple[Markup, str, str], ...]:
    return (
        (_T1, f"{t1:g} s", "time to sense and react"),
        (_T2, f"{t2:g} s", "time to stop"),
    )


def _metres(length: float) -> str:
    return f"{length:g} m"
