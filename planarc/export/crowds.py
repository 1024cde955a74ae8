"""What the crowds of an exported model are called, and why a run may end at their start.

px_member(number)         the name of a body
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from planarc.codegen.native.assembly import INT, POINTER, SELDOM, Code, Value
from planarc.core.diagnostic import Diagnostic
from planarc.export.tables import count_texts
from planarc.instance.crowd.table import Crowds
from planarc.instance.plan import crowd_names
from planarc.instance.text import text_constant
from planarc.ir.program import Program
from planarc.solve.stepping.refusal import overlap


def member_names(program: Program, selection: Sequence[int], shown: Callable[[str], str]) -> str:
    """`px_member`; `shown` makes a text one that a logger shows as it is."""
    texts = [shown(name) for name in Crowds(program, selection).names()]
    c = Code("px_member", POINTER, ((INT, "number"),))
    count_texts(c, c.flag(c.arguments[0] + 1), Value(c, POINTER, "@px_members"))
    return text_constant("px_members", "\0".join(texts)) + "\n" + c.text(SELDOM)


def overlaps(program: Program, mark: str = "") -> list[Diagnostic]:
    """Bodies of each crowd that begin in each other, at time 0: with a `mark` for each name and for
    how deep, or without them."""
    bodies = (mark, mark) if mark else ()
    return [overlap(program, crowd, 0.0, bodies, mark) for crowd in crowd_names(program)]
