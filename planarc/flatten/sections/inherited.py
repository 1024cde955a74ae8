"""Sections of a class that may inherit an equation twice.

In:   an equation section of one part, what the parts before it say
Out:  its typed equations, each of them once; warnings F228 where two classes say the same

What is written alike and means the same is one equation: a name of another package may not.

Reference: Modelica Language Specification 3.6, section 7.1.
"""

from __future__ import annotations

from typing import TypeAlias

from msgspec.structs import replace

from planarc.core.diagnostic import Related
from planarc.core.source import Span
from planarc.flatten.sections.equations import type_equations
from planarc.flatten.tree.nodes import Env, Session
from planarc.flatten.tree.repeated import repeated, stands_before, written
from planarc.ir import flat, syntax

Equations: TypeAlias = "list[flat.Equation]"
#: what was typed of an initial or other equation, by its text, with its places
Known: TypeAlias = "dict[tuple[bool, str], list[tuple[Equations, Span]]]"


def type_once(section: syntax.EquationSection, env: Env, known: Known) -> Equations:
    """The equations of a section, without those that are an earlier part's, too (7.1)."""
    layout, index = env.scope.instance.layout, env.scope.part.index
    if not repeated(layout):
        return type_equations(section.equations, env)
    typed: Equations = []
    for equation in section.equations:
        made = type_equations((equation,), env)
        others = known.setdefault((section.initial, written(equation)), [])
        first = next((where for pieces, where in others if pieces == made), None)
        if first is None or not stands_before(equation, layout, index):
            others.append((made, equation.span))
            typed += made
        elif made:
            _warn_of_copy(first, equation.span, env.session)
    return typed


def _warn_of_copy(first: Span, again: Span, session: Session) -> None:
    """Two classes say the same; of one class, extended twice, nobody need be told."""
    if first != again and first.source.name in session.own_files():
        message = f"`{' '.join(first.text.split())}` is inherited, too, and counts once"
        session.warn("F228", message, first, "leave one of the two out")
        note = (Related("the other one", again),)
        session.warnings[-1] = replace(session.warnings[-1], related=note)
