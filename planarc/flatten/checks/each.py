"""`each` where there is only one, and before a value for all entries together.

In:   the instances of a model
Out:  errors F224 for `Real x[2](each start={1, 2})`, as each entry has one value; warnings F224 in
      the user's own text for `Part part(each m=2)`, where there are no members

Only what a declaration says of its own component is looked at: further inside, and in what another
class modifies, `each` may belong to an array around.

Reference: Modelica Language Specification 3.6, section 7.2.5.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.flatten.terms.conform import type_text
from planarc.flatten.tree.lookup import components
from planarc.flatten.tree.nodes import Instance, Leaf, Session
from planarc.flatten.typing.modifiers import type_binding
from planarc.ir import syntax


def check_each(instances: Sequence[Instance], session: Session) -> None:
    """Report modifiers with an `each` that does not fit their component."""
    own, seen = session.own_files(), set[int]()
    for instance in instances:
        if id(instance.layout) in seen:
            continue
        seen.add(id(instance.layout))
        for _, element in components(instance):
            for argument in _with_each(element.definition):
                for found in _report(argument, element.node, own):
                    is_error = found.severity is Severity.ERROR
                    (session.errors if is_error else session.warnings).append(found)


def _with_each(definition: syntax.Declaration) -> Iterator[syntax.ElementModification]:
    if not isinstance(definition, syntax.Component) or definition.modification is None:
        return
    for argument in definition.modification.arguments:
        match argument:
            case syntax.ElementModification(each=True, name=(_,)):
                yield argument


def _report(
    argument: syntax.ElementModification, node: object, own: Collection[str]
) -> Iterator[Diagnostic]:
    if isinstance(node, Leaf) and node.type.dims:
        yield from _of_array(argument, node)
    elif isinstance(node, Leaf | Instance) and node.element and argument.span.source.name in own:
        message = f"`each` says nothing here: `{node.element.name}` is no array"
        yield Diagnostic("F224", message, argument.span, Severity.WARNING, "remove `each`")


def _of_array(argument: syntax.ElementModification, leaf: Leaf) -> Iterator[Diagnostic]:
    """An attribute with as many values as there are entries. What the type itself is an array of
    is one entry: `type Place = Real[2]; Place p[3](each start={1, 2});`."""
    binding = leaf.mod.sub(argument.name[0]).binding
    written = argument.modification.binding if argument.modification is not None else None
    if binding is None or binding.expression is not written:
        return  # another one stands further outside
    type_, sizes = type_binding(binding, leaf.type.dims).type, leaf.type.dims
    if len(leaf.layout.dimensions) < len(sizes) == len(type_.dims):
        message = f"`each` gives one value to every entry of `{leaf.name}`, and this is "
        hint = "remove `each`, and every entry gets its own value"
        yield Diagnostic("F224", message + type_text(type_), argument.span, hint=hint)
