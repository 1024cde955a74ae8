"""What cannot be stepped, bodies that start in each other, and those without room, in words."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence

from planarc.core.diagnostic import Diagnostic, UsageError, error, usage_error
from planarc.core.source import Span
from planarc.ir.expr import Expr
from planarc.ir.places import own_part
from planarc.ir.program import Program
from planarc.solve.contact import messages
from planarc.solve.stepping.crowd import Crowd
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


def no_implicit_steps(crowd: str) -> UsageError:
    """R483 for a crowd whose steps are asked to be implicit."""
    return usage_error(
        "R483",
        f"the crowd `{crowd}` is followed by steps with contacts: none is implicit",
        hint="leave `--stiff` out: stepping has a method of its own",
    )


def overlap(
    program: Program, crowd: str, t: float, bodies: Sequence[str] = (), depth: str = ""
) -> Diagnostic:
    """Two bodies of a crowd that start in each other, with their names where these are known."""
    told = f"{' and '.join(bodies)} overlap by {depth} m" if bodies else "bodies overlap"
    part = own_part(program, crowd)
    message, span = f"{told} in `{crowd}` at t = {t:.6g} s", part.span if part else None
    return Diagnostic("R480", message, span, hint="start the bodies apart, or where they touch")


def without_room(
    ports: Ports, crowds: Sequence[Crowd], first: Sequence[int], keys: Sequence[int], t: float
) -> Diagnostic:
    """R481 for contacts by their keys: those of touches are their numbers, those of a crowd, which
    begin at `first`, tell two of its members."""
    touches = ports.touches
    if keys[-1] < first[0]:
        return messages.pinched(touches, keys, t)
    components, names = [], []
    for key in keys:
        number = bisect_right(first, key) - 1
        if number < 0:
            components.append(touches.all[key].name)
            names.append(messages.named(touches, key))
            continue
        members = crowds[number].members
        pair = divmod((key - first[number]) // 2, len(members))
        met = " and ".join(body(members[m].read["x"]) for m in pair)
        components.append(members[0].crowd)
        names.append(f"`{members[0].crowd}` ({met})")
    return messages.without_room(touches, components, names, t)


def body(x: Expr) -> str:
    """A body by the expression of its place."""
    name = repr(x)
    return f"`{name.removesuffix('.r[1]')}`" if name.endswith(".r[1]") else "a wall"


def _error(
    program: Program, component: str, message: str, hint: str, span: Span | None = None
) -> Exception:
    part = own_part(program, component)
    return error("R483", message, part.span if part else span, hint=hint)
