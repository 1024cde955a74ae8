"""Discrete variables that are given what changes between events.

In:   the equations, algorithms and variables of a model
Out:  errors F284, and warnings where `noEvent` takes the events away or a function gives other
      results besides

    k = f(x)                 k an Integer: relations and `integer` in a function make no events
    x = sin(time)            x a discrete Real: only a when-clause may give it that
    b = noEvent(x > 0.5)     a warning, as for (k, y) = f(x)

What is discrete is found at events and kept between them, so that its value would be that of the
last event. Strings are left to `lower.texts`, which refuses what no variable can hold. A library's
own text is left alone, where the user could mend nothing.

Example: `k = integer(x)` is right, as each whole number that x passes is an event.

Reference: Modelica Language Specification 3.6, sections 3.8.4 and 4.4.4.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.source import Span
from planarc.flatten.checks.ticking import find_ticking
from planarc.flatten.tree.nodes import Session
from planarc.flatten.values.variability import STILL, cure_of_discrete, steps
from planarc.ir import flat
from planarc.ir.flatwalk import children, inside, set_by, variables_of_target

_WHENS = (flat.WhenEquation, flat.WhenStatement)
_PLACE = "leave its place in the parentheses empty"
_FIELD = "give the record field by field"
_RELATIONS = ("<", "<=", ">", ">=", "==", "<>")


class Given(Data):
    """A discrete variable, what gives it its value, and where."""

    target: flat.Variable
    value: flat.Expression
    span: Span
    beside: str = ""  # how to give it apart from what the same function gives besides


def check_discretes(
    equations: Collection[flat.Equation],
    algorithms: Collection[flat.Algorithm],
    variables: Collection[flat.Variable],
    session: Session,
) -> None:
    """Report discrete variables that are given what changes between events, in equations those of
    the user's text alone."""
    # Nothing of what ticks moves between events.
    ticking = find_ticking(equations, algorithms, variables) if session.clocked else set[str]()
    for name, problem in session.unsettled:
        if name not in ticking:
            session.keep(problem)
    discrete = {
        v.name: v
        for v in variables
        if v.variability is flat.Variability.DISCRETE and v.type.base is not flat.Base.STRING
    }
    if not discrete:
        return
    statements = [s for a in algorithms for s in a.statements]
    clocked = ticking.union(_set_in_whens(equations), _set_in_whens(statements))
    moving = _Moving(
        {v.name for v in variables if v.variability is flat.Variability.CONTINUOUS} - clocked
    )
    own = session.own_files()
    bound = (Given(v, v.binding, v.binding.span) for v in discrete.values() if v.binding)
    for given in (*bound, *_given(equations, discrete), *_given(statements, discrete)):
        if given.span.source.name in own and given.target.name not in clocked:
            _report(given, moving, session)


def _set_in_whens(items: Iterable[flat.Equation | flat.Statement]) -> Iterator[str]:
    for item in inside(items):
        if isinstance(item, _WHENS):
            yield from (v.name for part in inside((item,)) for v in set_by(part))


# What is given ----------------------------------------------------------------------------------


def _given(
    items: Iterable[flat.Equation | flat.Statement], discrete: dict[str, flat.Variable]
) -> Iterator[Given]:
    """The values outside of when-clauses, and the conditions on which they hang."""
    for item in items:
        match item:
            case flat.Equality(left=flat.Targets(items=targets), right=value):
                yield from _of_targets(targets, value, item.span, discrete)
            case flat.TupleAssignment(targets=targets, value=value):
                yield from _of_targets(targets, value, item.span, discrete)
            case flat.Equality(left=left, right=right) if not isinstance(left, flat.Targets):
                yield from _of_equality(left, right, item.span, discrete)
            case flat.Assignment(target=left, value=right):
                for target, given in _pairs(left, right):
                    yield from _of_sides(target, given, item.span, discrete)
            case flat.IfEquation() | flat.IfStatement():
                yield from _of_branches(item, discrete)
            case flat.ForStatement(range=range_, body=body):
                yield from _decided(range_, _given(body, discrete))
            case flat.WhileStatement(condition=condition, body=body):
                yield from _decided(condition, _given(body, discrete))


def _of_targets(
    targets: Sequence[flat.Expression | None],
    value: flat.Expression,
    span: Span,
    discrete: dict[str, flat.Variable],
) -> Iterator[Given]:
    for target in targets:
        for reference in variables_of_target(target) if target is not None else ():
            if reference.name in discrete:
                yield Given(discrete[reference.name], value, span, _PLACE)


def _of_equality(
    left: flat.Expression, right: flat.Expression, span: Span, discrete: dict[str, flat.Variable]
) -> Iterator[Given]:
    """What stands alone on one side. Of two variables, one is another name of the other; and an
    equation of Reals may be solved for what stands on the other side."""
    for one, other in _pairs(left, right):
        named = isinstance(one, flat.Reference) and isinstance(other, flat.Reference)
        yield from _of_sides(one, one if named else other, span, discrete)
        if one.type.base is not flat.Base.REAL:
            yield from _of_sides(other, other if named else one, span, discrete)


def _pairs(
    left: flat.Expression, right: flat.Expression
) -> Iterator[tuple[flat.Expression, flat.Expression]]:
    """Both sides entry by entry, or field by field, where they are written so."""
    parts = flat.Record | flat.Array
    if isinstance(left, parts) and isinstance(right, parts) and len(left.items) == len(right.items):
        for pair in zip(left.items, right.items, strict=True):
            yield from _pairs(*pair)
    else:
        yield left, right


def _of_sides(
    target: flat.Expression, value: flat.Expression, span: Span, discrete: dict[str, flat.Variable]
) -> Iterator[Given]:
    record = target.type.base is flat.Base.RECORD
    if record and not isinstance(value, flat.Call):
        return  # the fields are those of other variables
    for reference in variables_of_target(target):
        if reference.name in discrete:
            yield Given(discrete[reference.name], value, span, _FIELD if record else "")


def _of_branches(
    item: flat.IfEquation | flat.IfStatement, discrete: dict[str, flat.Variable]
) -> Iterator[Given]:
    bodies = [*(body for _, body in item.branches), item.otherwise]
    inner = [given for body in bodies for given in _given(body, discrete)]
    yield from inner
    for condition, _ in item.branches if inner else ():
        yield from _decided(condition, inner)


def _decided(condition: flat.Expression, inner: Iterable[Given]) -> Iterator[Given]:
    """The variables inside, which hang on the condition as well."""
    for given in inner:
        yield given
        yield Given(given.target, condition, condition.span)


# What moves --------------------------------------------------------------------------------------


class _Moving(Data):
    """Whether a value changes between events, too."""

    names: set[str]  # of the continuous variables

    def __call__(self, e: flat.Expression, silent: bool, watched: bool = True) -> bool:
        """With `silent`, relations in `noEvent` are such that make no events; without `watched`
        nothing makes any."""
        match e:
            case flat.Reference(name=name) if name in self.names:
                return True
            case flat.Builtin(function="time"):
                return True
            case flat.Builtin(function=function) if function in STILL:
                return False
            case flat.Builtin(function="noEvent", arguments=(inner,)) if silent:
                return self(inner, silent, watched=False)
            case flat.Builtin(function=function) if watched and steps(function):
                return False
            case flat.Binary(op=op) if watched and op in _RELATIONS:
                return False
        return any(self(part, silent, watched) for part in children(e))


def _report(given: Given, moving: _Moving, session: Session) -> None:
    if moving(given.value, silent=False) and not given.beside:
        session.errors.append(_refused(given))
    elif moving(given.value, silent=True):
        session.warnings.append(_followed(given))


def _refused(given: Given) -> Diagnostic:
    message = (
        f"the discrete variable `{given.target.name}` is given a value that changes between events"
    )
    return Diagnostic("F284", message, given.span, hint=cure_of_discrete(given.target.type))


def _followed(given: Given) -> Diagnostic:
    name, cure = given.target.name, cure_of_discrete(given.target.type)
    return Diagnostic(
        "F284",
        f"the discrete variable `{name}` is followed at events only, and nothing here makes one: "
        "its value is that of the last event",
        given.span,
        Severity.WARNING,
        hint=f"{given.beside}, and {cure}" if given.beside else f"leave `noEvent` out, or {cure}",
    )
