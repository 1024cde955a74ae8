"""What cannot be stepped, and starts with bodies in each other, in words."""

from __future__ import annotations

from planarc.core.diagnostic import Diagnostic, error
from planarc.core.source import Span
from planarc.ir.expr import Expr
from planarc.ir.places import own_part
from planarc.ir.program import Program
from planarc.solve.contact import messages
from planarc.solve.stepping.ports import Ports

#: The law that is a stiff spring, to be followed by an integrator.
_COMPLIANT = "PlanarMultiBody.Contacts.Internal.CompliantTouch"


def refuse_what_events_need(ports: Ports) -> None:
    """Raises R483 for a model without contacts, or with some that steps cannot take."""
    program, touches = ports.program, ports.touches
    hint = "leave `--contact stepping` out"
    yielding = next((p for p in program.parts if p.class_name == _COMPLIANT), None)
    if yielding is not None:
        name = yielding.name.partition(".")[0]
        message = f"`{name}` yields: steps of one length would have to be as short as it is stiff"
        raise _error(program, yielding.name, message, f"take the rigid law, or {hint}")
    for i in [i for i, bound in enumerate(touches.bound) if bound]:
        message = (
            f"{messages.named(touches, i)} rubs with the force that it carries: that takes events"
        )
        raise _error(program, touches.all[i].name, message, hint, touches.all[i].span)
    if not ports.count:
        message = f"`{program.name}` has no contacts that could be stepped"
        raise error("R483", message, program.span, hint=hint)


def overlap(
    ports: Ports, depth: float, t: float, first: Expr, second: Expr, crowd: str
) -> Diagnostic:
    """Two bodies of a crowd that start in each other, told by the expressions of their places."""
    name, other = _body(first), _body(second)
    message = f"{name} and {other} overlap by {depth:.3g} m in `{crowd}` at t = {t:.6g} s"
    part = own_part(ports.program, crowd)
    span = part.span if part else None
    return Diagnostic("R480", message, span, hint="start the bodies apart, or where they touch")


def _body(x: Expr) -> str:
    name = repr(x)
    return f"`{name.removesuffix('.r[1]')}`" if name.endswith(".r[1]") else "a wall"


def _error(
    program: Program, component: str, message: str, hint: str, span: Span | None = None
) -> Exception:
    part = own_part(program, component)
    return error("R483", message, part.span if part else span, hint=hint)
