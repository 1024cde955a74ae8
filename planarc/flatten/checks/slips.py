"""Formulas that say something else than was mostly meant.

In:   FlatModel, the names of the user's files
Out:  warnings F331 (degrees) and F332 (a root)

    sin(45)      a sine, cosine or tangent takes radian: a number such as people write in degrees
    x^1/2        is half of x, as a power binds more than a division: a root was meant

Example: `F*cos(30)` is 0.154*F, and not 0.866*F.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.unit import turns
from planarc.ir import flat
from planarc.ir.flatwalk import expressions_of_function, expressions_of_model, nodes_of

_OF_ANGLES = ("sin", "cos", "tan")
#: Angles that people write in degrees.
_DEGREES = (15, 30, 45, 60, 75, 90, 120, 135, 150, 180, 270, 360)


def find_slips(
    model: flat.FlatModel, files: Collection[str], distinct: flat.FlatModel
) -> Iterator[Diagnostic]:
    """Each of them once, in the files that the user works on. A `distinct` part of the model has
    all that can be wrong in it."""
    expressions = [*expressions_of_model(distinct)]
    for function in model.functions:
        expressions += expressions_of_function(function)
    seen = set[tuple[str, int]]()
    own = (e for e in expressions if e.span.source.name in files)
    for e in nodes_of(own):
        place = e.span.source.name, e.span.start
        if place in seen:
            continue
        found = _degrees(e) or _root(e)
        if found is not None:
            seen.add(place)
            yield found


def _degrees(e: flat.Expression) -> Diagnostic | None:
    if not isinstance(e, flat.Builtin) or e.function not in _OF_ANGLES:
        return None
    angle = next((a for t in _terms(e.arguments[0]) if (a := _literal(t)) in _DEGREES), None)
    if angle is None:
        return None
    return Diagnostic(
        "F331",
        f"`{e.function}` takes radian: {angle:g} rad is {turns(angle)}",
        e.span,
        Severity.WARNING,
        hint=f"if degrees are meant, write `{angle:g}*pi/180` with `Modelica.Constants.pi`",
    )


def _root(e: flat.Expression) -> Diagnostic | None:
    match e:
        case flat.Binary(op="/", left=flat.Binary(op="^", left=base, right=power), right=by):
            if _literal(power) != 1 or _literal(by) is None:
                return None
            shown, number = base.span.text, f"{_literal(by):g}"
            if not shown.isidentifier():
                shown = "x"
            return Diagnostic(
                "F332",
                f"`^1/{number}` divides by {number}, as a power binds more than a division",
                e.span,
                Severity.WARNING,
                hint=f"for a root write `{shown}^(1/{number})`",
            )
    return None


def _terms(e: flat.Expression) -> Iterator[flat.Expression]:
    left = [e]
    while left:
        e = left.pop()
        if isinstance(e, flat.Binary) and e.op in ("+", "-"):
            left += (e.left, e.right)
        elif isinstance(e, flat.Unary):
            left.append(e.operand)
        else:
            yield e


def _literal(e: flat.Expression) -> float | None:
    number = e.value if isinstance(e, flat.Literal) else None
    return None if isinstance(number, bool | str) else number
