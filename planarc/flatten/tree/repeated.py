"""Equations that a class inherits twice, and that count once.

In:   a Layout, an equation of one of its parts
Out:  whether an earlier part says the same, as in `extends A; extends B`, where B extends A

What one class says twice itself are two equations.

Reference: Modelica Language Specification 3.6, section 7.1.
"""

from __future__ import annotations

from planarc.flatten.tree.nodes import Layout, Part
from planarc.ir import syntax


def written(equation: syntax.Equation) -> str:
    """An equation's text, however it is spaced."""
    return "".join(equation.span.text.split())


def repeated(layout: Layout) -> dict[str, int]:
    """The texts of equations that stand in several parts, each with the first of these; looked for
    once a class."""
    if layout.repeated is None:
        seen, again = dict[str, int](), dict[str, int]()
        parts = [p for p in layout.parts if p.definition.sections]
        for part in parts if len(parts) > 1 else ():
            own = _texts(part)
            again |= {text: seen[text] for text in own & seen.keys()}
            seen = dict.fromkeys(own, part.index) | seen
        layout.repeated = again
    return layout.repeated


def _texts(part: Part) -> set[str]:
    sections = (s for s in part.definition.sections if isinstance(s, syntax.EquationSection))
    return {written(e) for s in sections for e in s.equations}


def stands_before(equation: syntax.Equation, layout: Layout, index: int) -> bool:
    """Whether a part before this one has the same equation."""
    return repeated(layout).get(written(equation), index) != index


def without_repeated(
    equations: tuple[syntax.Equation, ...], layout: Layout, index: int
) -> tuple[syntax.Equation, ...]:
    """The equations of a part that no part before it has."""
    if index == 0 or not repeated(layout):
        return equations
    return tuple([e for e in equations if not stands_before(e, layout, index)])
