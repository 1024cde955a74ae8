"""The inputs of the function whose brackets a place is in, and which of them is being written."""

from __future__ import annotations

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.editor import hover
from planarc.editor.context import Context, Where, context_at
from planarc.editor.view import View
from planarc.flatten.tree import lookup, sight
from planarc.flatten.tree.nodes import RECORD_KINDS
from planarc.ir import syntax


class Signature(Data):
    label: str
    description: str
    #: name, description of each input
    inputs: tuple[tuple[str, str], ...]
    active: int


def signature_at(view: View, offset: int) -> Signature | None:
    """The function around a place; None outside of calls."""
    context = context_at(view.text, offset)
    in_call = context.where in (Where.CALL, Where.VALUE) and context.head
    if not in_call or context.path:
        return None
    elements = sight.find_path(view.scope_at(offset), context.head)
    if len(elements) != len(context.head) or not elements[-1].is_class:
        return None
    try:
        instance = sight.opened(elements[-1])
    except PlanarcError:
        return None
    kind = instance.layout.kind
    if kind is not syntax.ClassKind.FUNCTION and kind not in RECORD_KINDS:
        return None
    declared = [(n, e.definition) for n, e in lookup.components(instance) if not e.protected]
    taken = [
        node
        for _, node in declared
        if isinstance(node, syntax.Component)
        and (kind in RECORD_KINDS or node.causality is syntax.Causality.INPUT)
    ]
    results = [
        n
        for n, node in declared
        if isinstance(node, syntax.Component) and node.causality is syntax.Causality.OUTPUT
    ]
    inputs = tuple((hover.argument_text(node), node.comment) for node in taken)
    left = f"{', '.join(results)} = " if results else ""
    label = f"{left}{instance.cls.definition.name}({', '.join(n for n, _ in inputs)})"
    return Signature(label, instance.cls.definition.comment, inputs, _active(context, taken))


def _active(context: Context, taken: list[syntax.Component]) -> int:
    names = [node.name for node in taken]
    return names.index(context.argument) if context.argument in names else context.position
