"""A Dae as text: one line an item."""

from __future__ import annotations

from collections.abc import Iterator

from planarc.ir.dae import Dae, Impact, Message, Reinit, SetDiscrete, Terminate, Variable
from planarc.ir.expr import symbol_text, text
from planarc.ir.flat import StateSelect
from planarc.ir.text.sorted import noted


def dae_text(dae: Dae) -> str:
    return "\n".join(_lines(dae)) + "\n"


def _lines(dae: Dae) -> Iterator[str]:
    yield f"model {dae.name}"
    for p in dae.parameters:
        kind = "constant" if p.constant else "parameter"
        yield noted(f"  {kind} {p.kind.value} {p.name} = {text(p.value)}", p.span)
    for title, variables in (
        ("variables", dae.variables),
        ("discrete variables", dae.discretes),
        ("inputs", dae.inputs),
    ):
        if variables:
            yield f"{title}"
        for v in variables:
            yield noted(f"  {v.kind.value} {v.name}{_attributes(v)}", v.span)
    for title, equations in (
        ("equations", dae.equations),
        ("initial equations", dae.initial_equations),
        ("discrete equations", dae.discrete_equations),
    ):
        if equations:
            yield title
        for e in equations:
            yield noted(f"  {text(e.left)} = {text(e.right)}", e.span)
    yield from _event_lines(dae)


def _attributes(v: Variable) -> str:
    items = []
    if v.start is not None:
        items.append(f"start={text(v.start)}")
    if v.fixed:
        items.append("fixed=true")
    if v.state_select is not StateSelect.DEFAULT:
        items.append(f"stateSelect={v.state_select.name.lower()}")
    return f"({', '.join(items)})" if items else ""


def _event_lines(dae: Dae) -> Iterator[str]:
    if dae.relations:
        yield "relations"
    for i, r in enumerate(dae.relations):
        sign = "<" if r.strict else "<="
        yield noted(f"  event[{i}]: {r.text}: {text(r.zero)} {sign} 0", r.span)
    for i, s in enumerate(dae.samplers):
        yield noted(f"  $sample[{i}]: sample({text(s.start)}, {text(s.interval)})", s.span)
    for i, d in enumerate(dae.delays):
        yield noted(f"  past{i + 1}: {d.signal}", d.span)
    for w in dae.whens:
        for i, (name, actions) in enumerate(w.branches):
            yield noted(f"{'elsewhen' if i else 'when'} {name}", w.span)
            for a in actions:
                yield noted(f"  {action_text(a)}", a.span)
    if dae.assertions:
        yield "assertions"
    for assertion in dae.assertions:
        yield noted(f"  {text(assertion.condition)}", assertion.span)


def action_text(action: object) -> str:
    match action:
        case SetDiscrete(name, value):
            return f"{name} := {text(value)}"
        case Reinit(symbol, value):
            return f"reinit({symbol_text(*symbol.data)}, {text(value)})"
        case Impact(arguments):
            return f"impact({', '.join(map(text, arguments))})"
        case Terminate(message):
            return f"terminate({message_text(message)})"
    return f"assert({text(action.condition)})"  # type: ignore[attr-defined]


def message_text(message: Message) -> str:
    parts = (f'"{p}"' if isinstance(p, str) else f"String({text(p[0])})" for p in message.parts)
    return " + ".join(parts)
