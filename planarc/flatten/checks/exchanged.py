"""Controllers whose two inputs are exchanged: the set value comes from a sensor, the measured one
from a source.

In:   the connections
Out:  a warning F336 for each

The inputs of a controller are `u_s` and `u_m`. With both exchanged it drives away from the set
value, which no equation says is wrong. Those of a difference may be exchanged on purpose: a gain
behind it has the other sign then.

Example: `connect(angle.phi, pid.u_s); connect(step.y, pid.u_m);`
"""

from __future__ import annotations

from collections.abc import Iterable

from planarc.core.diagnostic import Diagnostic, Related, Severity
from planarc.flatten.connect.connect import Connection
from planarc.flatten.tree.nodes import Instance, Leaf, Session
from planarc.ir import syntax

#: The input that is set, and the one that is measured.
_SET, _MEASURED = ".u_s", ".u_m"
#: What a class is in whose name this stands.
_SOURCES, _SENSORS = ".Sources.", ".Sensors."


def check_exchanged(connections: Iterable[Connection], session: Session) -> None:
    given: dict[str, tuple[Connection, str, str]] = {}  # by input: what gives it, and its class
    for connection in connections:
        sides = connection.left, connection.right
        for end, other in (sides, sides[::-1]):
            if _is(end.node, syntax.Causality.INPUT) and _is(other.node, syntax.Causality.OUTPUT):
                given[end.name] = (connection, other.name, _class_of(other.node))
    for name, (connection, sensor, kind) in given.items():
        block = name.removesuffix(_SET)
        measured = given.get(f"{block}{_MEASURED}") if block != name else None
        if measured is None or _SENSORS not in kind or _SOURCES not in measured[2]:
            continue
        place, source, _ = measured
        session.warnings.append(
            Diagnostic(
                "F336",
                f"`{block}` takes what `{sensor}` measures for the set value `u_s`, and "
                f"`{source}` for the measured one: it drives away from where it is to go",
                connection.span,
                Severity.WARNING,
                hint=f"exchange them: write `connect({sensor}, {block}{_MEASURED});` and "
                f"`connect({source}, {name});`",
                related=(Related("the other one", place.span),),
            )
        )


def _is(node: Leaf | Instance, causality: syntax.Causality) -> bool:
    """Whether a connector is an input or output of a component."""
    return isinstance(node, Leaf) and node.causality is causality and node.parent.parent is not None


def _class_of(node: Leaf | Instance) -> str:
    return f".{node.parent.cls.name}" if node.parent is not None else ""
