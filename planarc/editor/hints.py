"""What an editor shows beside a text: values of computed parameters, sizes, mobility; lenses.

In:   Text, Finding and Facts of its models
Out:  Hint   a label behind a character
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from planarc.core.data import Data
from planarc.core.prose import counted
from planarc.core.source import Span
from planarc.editor.check import Finding, models_of
from planarc.editor.facts import Facts, shown
from planarc.editor.texts import Text
from planarc.ir import syntax
from planarc.ir.syntaxwalk import references_in

_MOST = 4  # values of an array


class Hint(Data):
    at: int
    label: str
    tip: str


class Lens(Data):
    place: Span
    name: str


def hints_of(
    text: Text, findings: Mapping[str, Finding], facts: Mapping[str, Facts], start: int, end: int
) -> Iterator[Hint]:
    """The hints between two characters of a text."""
    for name, definition in text.classes.items():
        if definition.span.end < start or definition.span.start > end:
            continue
        finding = findings.get(name)
        if finding is not None and finding.checked is not None and name not in text.broken:
            yield from _mobility(definition, finding)
        if name in facts:
            yield from _values(definition, facts[name], start, end)


def _mobility(definition: syntax.ClassDef, finding: Finding) -> Iterator[Hint]:
    checked = finding.checked
    assert checked is not None
    words = [counted(checked.states, "state")]
    if checked.mechanism is not None and checked.mechanism.bodies:
        count = checked.mechanism.mobility
        rank = count if checked.mobility is None else checked.mobility.rank
        words.insert(0, f"mobility {rank}" + (f" ({count} by count)" if rank != count else ""))
    before = counted(checked.equations_before, "equation")
    tip = f"{before}, {checked.equations_after} after reduction"
    yield Hint(definition.name_span.end, ", ".join(words), tip)


def _values(definition: syntax.ClassDef, facts: Facts, start: int, end: int) -> Iterator[Hint]:
    composition = definition.composition
    for element in () if composition is None else composition.elements:
        if not isinstance(element, syntax.Component) or not start <= element.span.end <= end:
            continue
        binding = element.modification.binding if element.modification else None
        found = facts.of(element.name)
        computed = binding is not None and next(references_in(binding), None) is not None
        if computed and found and all(f.parameter and f.value is not None for _, f in found):
            values = [shown(f.value or 0.0) for _, f in found]
            unit = found[0][1].unit
            label = values[0] if len(values) == 1 else _braces(values)
            yield Hint(element.span.end, f"= {label}{' ' + unit if unit else ''}", element.comment)
        sizes = facts.sizes.get(element.name, ())
        written = (*element.dimensions, *element.type_dimensions)
        if sizes and any(not isinstance(d, syntax.Integer) for d in written):
            text = " x ".join("?" if d is None else str(d) for d in sizes)
            yield Hint(element.span.start + len(element.name), f"[{text}]", "size")


def _braces(values: list[str]) -> str:
    return "{" + ", ".join(values[:_MOST]) + (", ..." if len(values) > _MOST else "") + "}"


def lenses_of(text: Text) -> Iterator[Lens]:
    """The models of a text that can be run, at their names."""
    for name in models_of(text):
        yield Lens(text.classes[name].name_span, name)
