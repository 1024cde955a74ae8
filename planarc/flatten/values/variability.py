"""Variability of expressions: how often a value may change.

Reference: Modelica Language Specification 3.6, section 3.8.
"""

from __future__ import annotations

from planarc.flatten.tree.lookup import leaf_named
from planarc.flatten.tree.nodes import Session
from planarc.ir import flat
from planarc.ir.flatwalk import CONVERSIONS, OUTWARDS, children
from planarc.runtime import elementary

_CONSTANT = flat.Variability.CONSTANT
_DISCRETE = flat.Variability.DISCRETE
_CONTINUOUS = flat.Variability.CONTINUOUS

#: results that change at events, whatever their arguments
_FLAGS = frozenset({"initial", "terminal", "sample", "interval", "firstTick", "Clock"})
#: results that change at events only, in `noEvent` as well
_HELD = frozenset({"pre", "edge", "change", "previous"}) | CONVERSIONS | OUTWARDS
#: results that no argument moves between events
STILL = _FLAGS | _HELD | {"size", "ndims"}


def variability_of(
    expression: flat.Expression, session: Session, hidden: frozenset[str] = frozenset()
) -> flat.Variability:
    """The variability of an expression: the highest of what it depends on. `hidden` are
    local names, whose values are known only when run."""
    match expression:
        case flat.Literal() | flat.Slice():
            return _CONSTANT
        case flat.Reference(name=name, subscripts=subscripts):
            leaf = None if name in hidden else leaf_named(session, name)
            own = _CONTINUOUS if leaf is None else leaf.variability
            return max(own, _highest(subscripts, session, hidden))
        case flat.Builtin(function=function, arguments=arguments):
            if function in ("size", "ndims"):
                return _CONSTANT
            if function == "time":
                return _CONTINUOUS
            own = _highest(arguments, session, hidden)
            if function in _FLAGS:
                return _DISCRETE
            return min(own, _DISCRETE) if function in _HELD or steps(function) else own
        case flat.Binary(op="<" | "<=" | ">" | ">=" | "==" | "<>", left=left, right=right):
            return min(_highest((left, right), session, hidden), _DISCRETE)
    return _highest(children(expression), session, hidden)


def steps(function: str) -> bool:
    """Whether a function rounds its argument: its result changes at events, but in `noEvent`."""
    row = elementary.TABLE.get(function)
    return function == "integer" or (row is not None and row.slopes is None)


def cure_of_discrete(type_: flat.Type) -> str:
    """The hint for a discrete variable that is given what changes between events."""
    cure = "set it in a when-clause, such as `when sample(0, 0.01) then`"
    return cure if type_.base is not flat.Base.REAL else f"declare it without `discrete`, or {cure}"


def _highest(
    expressions: flat.Expressions, session: Session, hidden: frozenset[str]
) -> flat.Variability:
    highest = _CONSTANT
    for expression in expressions:
        highest = max(highest, variability_of(expression, session, hidden))
        if highest is _CONTINUOUS:
            break
    return highest
