"""Connectors of the user's with unequal numbers of flow variables and of potentials.

In:   all instances
Out:  warnings F324, one a class

Each connection makes potentials equal and lets flows sum to zero; a connector on which both do not
come in equal numbers leaves out what its components need, or says too much. Mostly `flow` is
forgotten: then currents of connected pins are equal instead of summing to zero.

Reference: Modelica Language Specification 3.6, section 9.3.1.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from planarc.core.diagnostic import Once, Severity
from planarc.core.prose import counted, listed
from planarc.flatten.connect.expand import is_expandable
from planarc.flatten.connect.rooting import EQUALITY
from planarc.flatten.terms.conform import scalar_count
from planarc.flatten.tree.nodes import Family, Instance, Layout, Leaf, Node, Session
from planarc.ir import flat, syntax


class Lopsided(Once):
    """A connector's flows and potentials differ in number."""


def check_connectors(instances: Iterable[Instance], session: Session) -> None:
    """Warn of each connector of the user's that is not balanced."""
    files = session.library.user_files()
    seen: set[str] = set()
    for instance in instances:
        cls = instance.cls
        if (
            instance.layout.kind is not syntax.ClassKind.CONNECTOR
            or cls.name in seen
            or cls.span.source.name not in files
        ):
            continue
        seen.add(cls.name)
        if not is_expandable(instance) and (found := _lopsided(instance)) is not None:
            session.warnings.append(found)


def _lopsided(connector: Instance) -> Lopsided | None:
    leaves = list(_leaves(connector))
    flows = [leaf for leaf in leaves if leaf.flow is syntax.Flow.FLOW]
    potentials = [leaf for leaf in leaves if leaf.flow is syntax.Flow.NONE]
    across = sum(scalar_count(leaf.type) for leaf in potentials)
    through = sum(scalar_count(leaf.type) for leaf in flows)
    if across == through or (across == 1 and not through) or _has_equality(leaves, connector):
        return None
    name = connector.cls.name.rpartition(".")[2]
    told = "no `flow` variable" if not flows else counted(through, "`flow` variable")
    others = listed(f"`{leaf.element.definition.name}`" for leaf in potentials)
    beside = f" beside {others}" if potentials else ""
    message = f"the connector `{name}` has {told}{beside}: as many are needed as potentials"
    one = (potentials or leaves)[-1].element.definition.name
    hint = f"declare what flows, a current or a force, as `flow Real {one}`; a signal is `input` "
    hint += "or `output`"
    if through > across:
        hint = "declare a potential, a voltage or a position, for each flow"
    return Lopsided(
        "F324", message, connector.cls.span, Severity.WARNING, hint, kind=connector.cls.name
    )


def _has_equality(leaves: Iterable[Leaf], connector: Instance) -> bool:
    """Whether it holds records with more variables than degrees of freedom, or is one."""
    layouts: list[Layout] = [
        connector.layout,
        *(p.layout for leaf in leaves for p in leaf.parent.outwards()),
    ]
    layouts += [leaf.layout for leaf in leaves]
    return any(EQUALITY in layout.members for layout in layouts)


def _leaves(instance: Instance) -> Iterator[Leaf]:
    """The variables of a connector that are neither inputs, outputs, streams nor parameters."""
    stack: list[Node | None] = [e.node for e in instance.elements.values()]
    while stack:
        node = stack.pop(0)
        if isinstance(node, Instance):
            stack += [e.node for e in node.elements.values()]
        elif isinstance(node, Family):
            stack += node.items
        elif isinstance(node, Leaf):
            signal = node.causality is not syntax.Causality.NONE
            varies = node.variability > flat.Variability.PARAMETER
            if varies and not signal and node.flow is not syntax.Flow.STREAM:
                yield node
