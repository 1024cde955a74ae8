"""The text that an editor shows of a name: declaration, description, unit, value, block, state."""

from __future__ import annotations

from collections.abc import Iterator

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Span
from planarc.editor.facts import Fact, Facts, shown
from planarc.editor.meaning import Meaning, meaning_at
from planarc.editor.mentions import Kind, Mention
from planarc.editor.view import View
from planarc.flatten.tree import sight
from planarc.flatten.tree.nodes import Element
from planarc.flatten.typing import builtins
from planarc.ir import syntax

#: The predefined attributes (4.9).
ATTRIBUTES = {
    "start": "the value at the start: a guess, or held where `fixed = true`",
    "fixed": "= true, if the start value is held",
    "min": "the least value that makes sense",
    "max": "the greatest value that makes sense",
    "unit": "the unit of the value",
    "displayUnit": "the unit that a user sees",
    "quantity": "the physical quantity",
    "nominal": "the size that values have, for tolerances",
    "stateSelect": "whether it is preferred as a state",
    "unbounded": "= true, if values may lie far from zero",
}
_MOST = 6  # values and states told


class Shown(Data):
    markdown: str
    span: Span


def hover(view: View, offset: int, facts: Facts | None = None) -> Shown | None:
    """The text about the name at a place; `facts` are those of the class around."""
    found = meaning_at(view, offset)
    if found is None:
        return None
    mention, meaning = found
    if meaning is None:
        if mention.kind is Kind.REFERENCE and builtins.is_name(mention.name):
            return Shown(_code(f"function {mention.name}") + "\n\nbuilt-in function", mention.span)
        return None
    told = [t for t in (_declaration(meaning), *_words(meaning)) if t]
    if facts is not None:
        told += _facts(facts, ".".join(variable_path(mention)))
    return Shown("\n\n".join(told), mention.span)


def variable_path(mention: Mention) -> tuple[str, ...]:
    """The name of a variable or component in the model whose text mentions it."""
    if mention.kind in (Kind.REFERENCE, Kind.DECLARATION) and not mention.is_type:
        return mention.path
    return ()


def declaration_text(node: syntax.Declaration) -> str:
    """A declaration on one line, as the text has it."""
    if isinstance(node, syntax.ClassDef):
        partial = "partial " if node.partial else ""
        return f"{partial}{node.kind.value} {node.name}"
    prefixes = [w for w in ("final", "inner", "outer", "replaceable") if getattr(node.prefixes, w)]
    words = (node.flow.value, node.variability.value, node.causality.value)
    dimensions = "".join(f"[{', '.join(d.span.text for d in node.type_dimensions)}]"[:-1] + "]"
                         for _ in node.type_dimensions[:1])  # fmt: skip
    text = " ".join(node.span.text.split())
    return " ".join([*prefixes, *(w for w in words if w), str(node.type) + dimensions, text])


def _code(text: str) -> str:
    return f"```modelica\n{text}\n```"


def _declaration(meaning: Meaning) -> str:
    if meaning.attribute:
        return _code(f"attribute {meaning.name}")
    node = meaning.declared
    if isinstance(node, syntax.Component | syntax.ClassDef):
        return _code(declaration_text(node))
    if meaning.literal_of:
        return _code(f"{meaning.literal_of}.{meaning.name}")
    return _code(f"for {meaning.name}")


def _words(meaning: Meaning) -> Iterator[str]:
    if meaning.attribute:
        yield ATTRIBUTES.get(meaning.name, "")
    node = meaning.declared
    if isinstance(node, syntax.Component | syntax.ClassDef | syntax.EnumerationLiteral):
        yield node.comment
    if meaning.element is not None and isinstance(node, syntax.Component):
        yield from _type_words(meaning.element)
    if isinstance(node, syntax.Component) and meaning.element is not None:
        yield f"in `{meaning.element.scope.part.cls.name}`"
    elif isinstance(node, syntax.ClassDef) and node.kind is syntax.ClassKind.FUNCTION:
        yield _code(signature(node))


def _type_words(element: Element) -> Iterator[str]:
    try:
        cls = sight.class_behind(element)
        layout = sight.scope_of(cls).instance.layout
    except PlanarcError:
        return
    if layout.builtin is None:
        if cls.definition.comment:
            yield f"`{cls.name}`: {cls.definition.comment}"
        return
    unit = attribute(element, "unit")
    if unit:
        yield f"unit: `{unit}`"


def attribute(element: Element, name: str) -> str:
    """The text of a string attribute of a component or of its type, as the texts give it."""
    assert isinstance(element.definition, syntax.Component)
    cls = sight.class_behind(element)
    parts = sight.scope_of(cls).instance.layout.parts
    modifications = [element.definition.modification, *(p.modification for p in parts)]
    modifications += [
        p.definition.body.modification
        for p in parts
        if isinstance(p.definition.body, syntax.ShortClass)
    ]
    for modification in modifications:
        for argument in () if modification is None else modification.arguments:
            if isinstance(argument, syntax.ElementModification) and argument.name == (name,):
                value = argument.modification and argument.modification.binding
                if isinstance(value, syntax.String):
                    return value.value
    return ""


def signature(definition: syntax.ClassDef) -> str:
    """A function's call with its results: `y = f(u, k = 1)`."""
    composition = definition.composition
    elements = () if composition is None else composition.elements
    declared = [e for e in elements if isinstance(e, syntax.Component)]
    inputs = [argument_text(e) for e in declared if e.causality is syntax.Causality.INPUT]
    outputs = [e.name for e in declared if e.causality is syntax.Causality.OUTPUT]
    left = outputs[0] if len(outputs) == 1 else f"({', '.join(outputs)})"
    return f"{left} = {definition.name}({', '.join(inputs)})"


def argument_text(node: syntax.Component) -> str:
    binding = node.modification.binding if node.modification else None
    return node.name if binding is None else f"{node.name} = {binding.span.text}"


def _facts(facts: Facts, name: str) -> Iterator[str]:
    found = facts.of(name) if name else ()
    known = [(n, f) for n, f in found if f.value is not None]
    if known and len(found) == 1:
        yield f"at the start: `{_value(known[0][1])}`"
    elif known:
        values = ", ".join(_value(f) for _, f in known[:_MOST])
        yield f"at the start: `{{{values}{', ...' if len(known) > _MOST else ''}}}`"
    if name in facts.sizes:
        yield "size: `" + " x ".join("?" if d is None else str(d) for d in facts.sizes[name]) + "`"
    blocks = dict.fromkeys(f.block for _, f in found if f.block)
    yield from (f"computed in {block}" for block in blocks)
    if any(f.is_state for _, f in found):
        yield "a state, or a candidate for one"
    states = facts.states_in(name) if name and not found else ()
    if states:
        more = ", ..." if len(states) > _MOST else ""
        yield "candidates for states: " + ", ".join(f"`{s}`" for s in states[:_MOST]) + more


def _value(fact: Fact) -> str:
    return shown(fact.value or 0.0, fact.unit)
