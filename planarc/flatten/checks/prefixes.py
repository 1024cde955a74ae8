"""Whether the words before a component suit its class.

In:   the components and variables of a model
Out:  errors F239, once for each declaration

    parameter, constant, discrete, input, output, flow, stream    not before a model or a block
    parameter, constant                     not before a connector
    input, output                           not before what has a prefix of these four inside
    flow, stream                            not before what has one of these two inside
    flow                                    before Reals only

Reference: Modelica Language Specification 3.6, sections 4.4.2.2 and 9.3.
"""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.diagnostic import Diagnostic, Related
from planarc.flatten.checks.kinds import prefixes_of
from planarc.flatten.tree.lookup import components
from planarc.flatten.tree.nodes import Family, Instance, Leaf, Node, Session
from planarc.ir import flat, syntax
from planarc.ir.syntax import ClassKind

_MODELS = (ClassKind.MODEL, ClassKind.BLOCK)
_CLASHING = {
    "flow": ("flow", "stream"),
    "stream": ("flow", "stream"),
    "input": ("input", "output", "flow", "stream"),
    "output": ("input", "output", "flow", "stream"),
}


def check_prefixes(instances: list[Instance], leaves: list[Leaf], session: Session) -> None:
    """Report prefixes that do not suit their components."""
    seen: set[tuple[int, int]] = set()
    for instance in instances:
        element = instance.element
        key = (id(element and element.definition), id(instance.layout))
        if key in seen:
            continue
        seen.add(key)
        if element is not None and isinstance(element.definition, syntax.Component):
            session.errors += _component(instance, element.definition)
    for leaf in leaves:
        if leaf.flow is not syntax.Flow.NONE and leaf.type.base is not flat.Base.REAL:
            message = f"`{leaf.flow.value}` stands before Reals only: `{leaf.name}` is none"
            session.errors.append(Diagnostic("F239", message, leaf.span))


def _component(instance: Instance, definition: syntax.Component) -> Iterator[Diagnostic]:
    layout = instance.layout
    words = prefixes_of(definition)
    own = {w for w in words if w not in ("inner", "outer")}
    of_type = {layout.causality.value, layout.flow.value} - {""}
    kind = f"the {layout.kind.value} `{instance.cls.name}`"
    if layout.kind in _MODELS:
        refused = own
    elif instance.is_connector:
        refused = own & {"parameter", "constant"}
    else:
        refused = set()
    for word in sorted(refused):
        message = f"`{word}` cannot stand before a component of {kind}"
        yield Diagnostic("F239", message, definition.span, hint=f"remove `{word}`")
    around = sorted((own | of_type).intersection(_CLASHING) - refused)
    inside = next(_directed(instance, _CLASHING[around[0]]), None) if around else None
    if inside is not None:
        leaf, word = inside
        yield Diagnostic(
            "F239",
            f"`{around[0]}` cannot stand before {kind}, whose `{leaf.element.name}` is `{word}`",
            definition.span,
            related=(Related("declared here", leaf.span),),
        )


def _directed(instance: Instance, clashing: tuple[str, ...]) -> Iterator[tuple[Leaf, str]]:
    """Variables that have one of the words by their own declaration, with the word."""
    for leaf in _leaves(instance):
        declared = leaf.element.definition
        if isinstance(declared, syntax.Component):
            types = (leaf.layout.causality.value, leaf.layout.flow.value)
            words = [w for w in (*prefixes_of(declared), *types) if w in clashing]
            yield from ((leaf, word) for word in words[:1])


def _leaves(node: Node) -> Iterator[Leaf]:
    if isinstance(node, Leaf):
        yield node
    elif isinstance(node, Family):
        for item in node.items[:1]:  # the others are alike
            yield from _leaves(item)
    elif isinstance(node, Instance):
        for _, element in components(node):
            if element.node is not None:
                yield from _leaves(element.node)
