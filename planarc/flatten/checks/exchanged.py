"""Controllers whose two inputs are exchanged: the set value comes from a sensor, the measured one
from a source.

In:   the connections
Out:  a warning F336 for each

The inputs of a controller are `u_s` and `u_m`. With both exchanged it drives away from the set
value, which no equation says is wrong, unless a gain or a gear turns the sign. Those of a
difference, `u1` and `u2`, may be exchanged on purpose where a gain behind it has the other sign:
only where all gains up to a force or torque are known to be positive is it told.

Example: `connect(angle.phi, pid.u_s); connect(step.y, pid.u_m);`
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from planarc.core.diagnostic import PlanarcError, Related, Repelling, Severity
from planarc.flatten.connect.connect import Connection
from planarc.flatten.terms.constant import NotConstant
from planarc.flatten.tree.nodes import Instance, Leaf, Session
from planarc.flatten.values.evaluator import Evaluator
from planarc.ir import syntax

#: The input that is set, and the one that is measured.
_SET, _MEASURED = ".u_s", ".u_m"
#: A difference: what is added, and what is subtracted; what it gives.
_ADDED, _SUBTRACTED, _GIVEN = ".u1", ".u2", ".y"
_DIFFERENCE = ".Modelica.Blocks.Math.Feedback"
#: Blocks of one input that keep its sign, or change it by their parameter `k`.
_KEEPING = (
    ".Modelica.Blocks.Continuous.",
    ".Modelica.Blocks.Math.Gain",
    ".Modelica.Blocks.Nonlinear.",
)
#: What acts on a mechanism by the signal that it takes.
_ACTING = (".Sources.Torque", ".Sources.Force", ".Sources.Torque2", ".Sources.Force2")
#: Blocks between a difference and what acts, at most.
_MOST = 8
#: What a class is in whose name this stands.
_SOURCES, _SENSORS = ".Sources.", ".Sensors."


def check_exchanged(connections: Iterable[Connection], session: Session) -> None:
    given: dict[str, tuple[Connection, str, str]] = {}  # by input: what gives it, and its class
    for connection in connections:
        sides = connection.left, connection.right
        for end, other in (sides, sides[::-1]):
            if _is(end.node, syntax.Causality.INPUT) and _is(other.node, syntax.Causality.OUTPUT):
                given[end.name] = (connection, other.name, _class_of(other.node))
    for name, (connection, *_) in given.items():
        is_difference = name.endswith(_ADDED)
        first, second = (_ADDED, _SUBTRACTED) if is_difference else (_SET, _MEASURED)
        block = name.removesuffix(first)
        measured = f"{block}{second}"
        if block == name or measured not in given:
            continue
        sensor, kind = _origin(name, given, session)
        source, other_kind = _origin(measured, given, session)
        if _SENSORS not in kind or _SOURCES not in other_kind:
            continue
        if is_difference and not _acts_the_same_way(block, connections, given, session):
            continue
        if _a_sign_is_turned(session):
            return
        place, (_, to_set, _), (_, to_measure, _) = given[measured][0], given[measured], given[name]
        session.warnings.append(
            Repelling(
                "F336",
                f"`{block}` takes what `{sensor}` measures for the set value `{first[1:]}`, and "
                f"`{source}` for the measured one: it drives away from where it is to go",
                connection.span,
                Severity.WARNING,
                hint=f"exchange them: write `connect({to_measure}, {measured});` and "
                f"`connect({to_set}, {name});`",
                related=(Related("the other one", place.span),),
            )
        )


def _origin(
    name: str, given: Mapping[str, tuple[Connection, str, str]], session: Session
) -> tuple[str, str]:
    """What gives an input its value, and its class, beyond blocks that keep its sign."""
    _, output, kind = given[name]
    for _ in range(_MOST):
        block = output.removesuffix(_GIVEN)
        keeps = kind.startswith(_KEEPING) and _is_positive(f"{block}.k", session)
        if not keeps or f"{block}.u" not in given:
            break
        _, output, kind = given[f"{block}.u"]
    return output, kind


def _acts_the_same_way(
    block: str,
    connections: Iterable[Connection],
    given: Mapping[str, tuple[Connection, str, str]],
    session: Session,
) -> bool:
    """Whether what a difference gives acts on a mechanism, by way of positive gains alone."""
    kinds = {side.name: _class_of(side.node) for c in connections for side in (c.left, c.right)}
    if kinds.get(f"{block}{_GIVEN}") != _DIFFERENCE:
        return False
    for _ in range(_MOST):
        taken = [name for name, (_, output, _) in given.items() if output == f"{block}{_GIVEN}"]
        if len(taken) != 1:
            return False
        block, kind = taken[0].rpartition(".")[0], kinds[taken[0]]
        if kind.endswith(_ACTING):
            return True
        if not kind.startswith(_KEEPING) or not _is_positive(f"{block}.k", session):
            return False
    return False


def _a_sign_is_turned(session: Session) -> bool:
    """Whether a gain or the ratio of a gear is negative, which an exchange may make up for."""
    factors = (n for n in session.leaves if n.endswith((".k", ".ratio")))
    return any(_value(n, session) < 0 for n in factors)


def _is_positive(name: str, session: Session) -> bool:
    """Whether a parameter is known to be positive, or is none."""
    return name not in session.leaves or _value(name, session) > 0


def _value(name: str, session: Session) -> float:
    """The value of a parameter; that of no number, if it is not known before a run."""
    try:
        value = Evaluator(session).leaf_value(session.leaves[name])
    except (NotConstant, PlanarcError):
        return math.nan
    return value if isinstance(value, int | float) else math.nan


def _is(node: Leaf | Instance, causality: syntax.Causality) -> bool:
    """Whether a connector is an input or output of a component."""
    return isinstance(node, Leaf) and node.causality is causality and node.parent.parent is not None


def _class_of(node: Leaf | Instance) -> str:
    return f".{node.parent.cls.name}" if node.parent is not None else ""
