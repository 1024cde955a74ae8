"""Formulas that say something else than was mostly meant.

In:   FlatModel, the names of the user's files
Out:  warnings F331 (degrees), F332 (a root), F333 (a difference) and F334 (a when)

    sin(45)      a sine, cosine or tangent takes radian: a number such as people write in degrees
    phi > 90     so does what is compared with an angle, or added to it
    x^1/2        is half of x, as a power binds more than a division: a root was meant
    x - pre(x)   is 0 where x moves all the while and nothing sets it anew
    when f(x)    watches no relation, since those in functions and in noEvent make no events

Example: `F*cos(30)` is 0.154*F, and not 0.866*F.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from functools import cache

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.unit import turns
from planarc.ir import flat
from planarc.ir.flatwalk import (
    children,
    expressions_of_function,
    expressions_of_model,
    inside,
    nodes_of,
    set_by,
)

_OF_ANGLES = ("sin", "cos", "tan")
#: Angles that people write in degrees.
_DEGREES = (15, 30, 45, 60, 75, 90, 120, 135, 150, 180, 270, 360)
#: Those that hardly anybody means in radian, of a shaft that turns round and round either.
_NEVER_RADIAN = (45, 60, 90, 120, 135, 150, 180, 270, 360)
_SUMS = ("+", "-", "<", "<=", ">", ">=")


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
    moving = cache(lambda: _moving(model))
    angles = cache(lambda: {v.name for v in model.variables if v.attributes.unit == "rad"})
    for e in nodes_of(own):
        place = e.span.source.name, e.span.start
        if place in seen:
            continue
        found = _degrees(e) or _beside_angle(e, angles) or _root(e) or _no_difference(e, moving)
        if found is not None:
            seen.add(place)
            yield found
    for condition in _conditions(distinct):
        if condition.span.source.name in files and (silent := _silent(condition, moving)):
            yield silent


def _moving(model: flat.FlatModel) -> set[str]:
    """The variables that move all the while, and that nothing sets anew at an event."""
    items = [*inside(model.equations), *(s for a in model.algorithms for s in inside(a.statements))]
    jumping = {e.variable.name for e in items if isinstance(e, flat.Reinit)}
    whens = [e for e in items if isinstance(e, flat.WhenEquation | flat.WhenStatement)]
    for when in whens:
        jumping |= {v.name for _, body in when.branches for i in inside(body) for v in set_by(i)}
    return {
        v.name
        for v in model.variables
        if v.type.base is flat.Base.REAL
        and v.variability is flat.Variability.CONTINUOUS
        and v.name not in jumping
    }


def _conditions(model: flat.FlatModel) -> Iterator[flat.Expression]:
    items = [*inside(model.equations), *(s for a in model.algorithms for s in inside(a.statements))]
    for item in items:
        if isinstance(item, flat.WhenEquation | flat.WhenStatement):
            yield from (condition for condition, _ in item.branches)


def _no_difference(e: flat.Expression, moving: Callable[[], set[str]]) -> Diagnostic | None:
    match e:
        case flat.Binary(
            op="-",
            left=flat.Reference(name=now),
            right=flat.Builtin(function="pre", arguments=(flat.Reference(name=before),)),
        ) if now == before and now in moving():
            return Diagnostic(
                "F333",
                f"`{now} - pre({now})` is 0: what moves all the while is the same right before an "
                "event",
                e.span,
                Severity.WARNING,
                hint=f"keep `{now}` of each event in a variable that a `when` sets, and take `pre` "
                "of that",
            )
    return None


def _silent(condition: flat.Expression, moving: Callable[[], set[str]]) -> Diagnostic | None:
    """The warning about a condition that becomes true between events, and makes none."""
    left, found = [condition], None
    while left:
        e = left.pop()
        if isinstance(e, flat.Unary | flat.Array) or (
            isinstance(e, flat.Binary) and e.op in ("and", "or")
        ):
            left += children(e)
            continue
        hides = isinstance(e, flat.Call) or (
            isinstance(e, flat.Builtin) and e.function == "noEvent"
        )
        if not hides or not any(_moves(part, moving) for part in nodes_of((e,))):
            return None  # another part may make events at the right instants
        found = e
    if found is None:
        return None
    what = "`noEvent`" if isinstance(found, flat.Builtin) else "a function"
    return Diagnostic(
        "F334",
        f"this `when` makes no event: relations in {what} are not watched",
        condition.span,
        Severity.WARNING,
        hint="write the relation itself in the condition, as `when x > limit then`",
    )


def _moves(e: flat.Expression, moving: Callable[[], set[str]]) -> bool:
    if isinstance(e, flat.Builtin):
        return e.function == "time"
    return isinstance(e, flat.Reference) and e.name in moving()


def _degrees(e: flat.Expression) -> Diagnostic | None:
    if not isinstance(e, flat.Builtin) or e.function not in _OF_ANGLES:
        return None
    angle = next((a for t in _terms(e.arguments[0]) if (a := _literal(t)) in _DEGREES), None)
    if angle is None:
        return None
    return _in_radian(f"`{e.function}` takes radian", angle, e)


def _beside_angle(e: flat.Expression, angles: Callable[[], set[str]]) -> Diagnostic | None:
    if not isinstance(e, flat.Binary) or e.op not in _SUMS:
        return None
    for number, other in ((e.left, e.right), (e.right, e.left)):
        angle = _literal(number)
        named = isinstance(other, flat.Reference) and other.name in angles()
        if angle is not None and abs(angle) in _NEVER_RADIAN and named:
            return _in_radian(f"`{' '.join(other.span.text.split())}` is in radian", angle, e)
    return None


def _in_radian(why: str, angle: float, e: flat.Expression) -> Diagnostic:
    return Diagnostic(
        "F331",
        f"{why}: {angle:g} rad is {turns(angle)}",
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
