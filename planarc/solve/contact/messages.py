"""What happens at touches, and why they cannot go on, in words."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.prose import listed
from planarc.ir.mechanism import GROUND, SPEEDS
from planarc.ir.places import own_part
from planarc.ir.program import Program
from planarc.solve.contact.bodies import bodies, fixed_together
from planarc.solve.contact.touches import Points, Touches
from planarc.solve.messages import event
from planarc.solve.messages.loops import given_of, joints_of
from planarc.solve.messages.sides import switch

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Impulses below this part of the largest at an instant are rounding.
FELT = 1e-12

_CONTOURS = "PlanarMultiBody.Contacts."
_YIELDS = (
    "drive by a force or a torque, let the contact yield (`law=Compliant`), or end the motion "
    "before"
)
_POINT = re.compile(r"(.*)\.\w+\[(\d+)\]$")


def named(touches: Points, i: int) -> str:
    """A touch as a user knows it: its component, and its point where there are several."""
    name = _touching(touches, i)
    found = _POINT.match(name)
    if found is None:
        return f"`{name}`"
    several = sum(t.name.startswith(f"{found[1]}.") for t in touches.all) > 1
    return f"`{found[1]}`" + f" (point {found[2]})" * several


def contact_of(touches: Points, i: int) -> str:
    """The component of a touch, all points of which it stands for."""
    name = _touching(touches, i)
    found = _POINT.match(name)
    return found[1] if found else name


def between(touches: Points, i: int) -> str:
    """A touch with the bodies that meet there: "`contact` of `ball` and the ground"."""
    met = _met(touches, i)
    return f"{named(touches, i)} of {met}" if met else named(touches, i)


def _met(touches: Points, i: int) -> str:
    """The bodies that meet at a touch; empty at joints that rub and without frames."""
    met = () if touches.bound[i] else bodies(touches.program, touches.all[i].name)
    return listed(met) if len(met) > 1 else ""


def told(
    touches: Points,
    before: Mapping[str, Vector],
    after: Mapping[str, Vector],
    begins: bool = False,
) -> list[str]:
    """What happened at an instant, one text for each touch to which something did; where the run
    `begins` with what rests, for each that was struck."""
    found, largest = [], float(after["impulse"].max())
    for i in range(len(touches.all)):
        texts = []
        if (impulse := after["impulse"][i]) > FELT * largest:
            texts.append(f"impact of {impulse:.4g} N.s")
        elif begins:
            continue
        was, held = before["held"][i], after["held"][i]
        old, way = before["way"][i], after["way"][i]
        if held and (not was or old != way) and way != 2:
            texts.append("sticks" if way == 0 else "slides")
        elif held and not was:
            texts.append("rests")
        if was and not held:
            texts.append("lets go")
        if texts:
            found.append(f"{between(touches, i)}: {', '.join(texts)}")
    return found


def unsolved(touches: Touches, t: float) -> Diagnostic:
    return event.unsolved(touches.program, touches.kernel, t, ())


def passed_through(touches: Points, i: int, pulled: bool) -> Diagnostic:
    """The refusal of a state of rest beyond what touches, or held by what only presses."""
    where = between(touches, i)
    message = f"the way down to rest leads through {where}"
    if pulled:
        message = f"at rest {where} would have to pull, and can only press"
    hint = (
        "let a run come to rest, with some damping: `planarc simulate --start-from RESULT` begins "
        "where it ends; or give start values at which it touches there"
    )
    return _found(touches, i, "R471", f"no equilibrium was found: {message}", hint)


def lost(touches: Points, i: int, t: float) -> Diagnostic:
    """Where more is not known of what was not solved."""
    message = f"what follows from {named(touches, i)} at t = {t:.6g} s could not be solved"
    hint = "the mechanism may be stretched or jammed here: look at its position at this time"
    return _found(touches, i, "R422", message, hint)


def _found(touches: Points, i: int, code: str, message: str, hint: str) -> Diagnostic:
    part = own_part(touches.program, touches.all[i].name)
    return Diagnostic(code, message, part.span if part else touches.all[i].span, hint=hint)


def overlapping(touches: Touches, i: int, gaps: Vector, t: float) -> Diagnostic:
    """The refusal of a start at which the contours of a touch are in each other."""
    found = overlap(touches, i, f"{-float(gaps[i]):.3g}", t)
    beyond = _beyond(touches.program, _touching(touches, i))
    if beyond is None:
        meant = _meant(touches, i, gaps)
        if " moves with " in meant:  # mostly this, and seldom the places
            return replace(found, hint=f"{meant.removeprefix('; ')}; else {found.hint}")
        return replace(found, hint=f"{found.hint}{meant}")
    way, end, _ = beyond
    value, limit = (_value(touches, name) for name in (way, end))
    message = f"`{way}` = {value:.4g} lies beyond the stop `{end}` = {limit:.4g} at t = {t:.6g} s"
    return replace(found, message=message, hint=f"{found.hint}{_turned(touches, way, value)}")


def stepped_over(touches: Touches, i: int, gaps: Vector, t: float) -> Diagnostic:
    """The refusal where a step of fixed length ends with the contours of a touch in each other."""
    found = overlap(touches, i, f"{-float(gaps[i]):.3g}", t)
    hint = (
        "a fixed step goes past the instant at which they meet: leave `--solver` and "
        "`--fixed-step` out, or take `--contact stepping` in the place of `--solver`"
    )
    return replace(found, hint=hint)


def _touching(touches: Points, i: int) -> str:
    return touches.all[i].name.removesuffix(".rigid").removesuffix(".touch")


def _value(touches: Touches, name: str) -> float:
    """Of a variable or a parameter, at this instant."""
    program, w = touches.program, touches.kernel.w
    values = {p.name: w[p.slot] for p in program.parameter_slots}
    values |= {c.name: c.sign * w[c.slot] for c in program.columns}
    return float(values[name])


def _turned(touches: Touches, way: str, value: float) -> str:
    """What to do where a coordinate between stops is minus that of a joint, which is so where the
    stops' ends are exchanged."""
    part, _, kind = way.rpartition(".")
    w = touches.kernel.w
    joints = (c for c in touches.program.candidates if c.display.rpartition(".")[2] == kind)
    other = next((c.display for c in joints if value and -w[c.slot] == value), None)
    if other is None:
        return ""
    return (
        f"; it is minus `{other}`: if it should be that, exchange what `{part}.frame_a` and "
        f"`{part}.frame_b` are connected to"
    )


def overlap(touches: Points, i: int, depth: str, t: float) -> Diagnostic:
    """The same where no values are known; `depth` is a number as it is told."""
    what = _met(touches, i) or "its two sides"
    message = f"{what} overlap by {depth} m in {named(touches, i)} at t = {t:.6g} s"
    hint = "start the bodies apart, or exactly where they touch"
    parameters = {p.name for p in touches.program.parameter_slots}
    name = _touching(touches, i)
    if f"{name}.length" in parameters:  # a rope, whose gap is what is left of its slack
        message = f"{named(touches, i)} is {depth} m too short to join {what} at t = {t:.6g} s"
        hint = f"give `{name}.length` a larger value, or start the bodies nearer to each other"
    if (beyond := _beyond(touches.program, name)) is not None:
        way, end, other = beyond
        message = f"`{way}` lies beyond the stop `{end}` at t = {t:.6g} s, by {depth} m"
        if f"{way.rpartition('.')[0]}.R" in parameters:
            message += f" at the radius `{way.rpartition('.')[0]}.R`"
        hint = f"start between the stops, or give `{end}` a {other} value"
    if switching := switch(touches.program, name):
        hint += f"; if they should be on the other side, set {switching}"
    return _found(touches, i, "R480", message, hint)


def _meant(touches: Touches, i: int, gaps: Vector) -> str:
    """What else may be wrong with a contact: a half plane that moves over the ground, or a contour
    that has the whole of the other one inside; empty where the two only overlap a little."""
    name = _touching(touches, i)
    contact = found[1] if (found := _POINT.match(name)) else name
    program, w = touches.program, touches.kernel.w
    classes = {p.name: p.class_name.removeprefix(_CONTOURS) for p in program.parts}
    radii = {p.name: w[p.slot] for p in program.parameter_slots if p.name.endswith(".radius")}
    ground = program.mechanism.links[GROUND].frames if program.mechanism else ()
    nearest = max(
        g for t, g in zip(touches.all, gaps, strict=True) if t.name.startswith(f"{contact}.")
    )
    for n, end, far in ((2, "b", "a"), (1, "a", "b")):
        solid = f"{contact}.contour{n}"
        kind, moves, still = classes.get(solid), f"{contact}.frame_{end}", f"{contact}.frame_{far}"
        if kind == "HalfPlane" and moves not in ground and still in ground:
            return (
                f"; `{solid}` moves with `{moves}`: if it is to stand still, exchange that with "
                f"`{still}`"
            )
        if nearest > -2 * radii.get(f"{contact}.contour{3 - n}.radius", 0.0):
            continue
        if kind == "HalfPlane":
            return (
                f"; if they should meet from the other side, turn `{solid}` round: what lies to "
                "the right of its `angle` is solid"
            )
        if kind == "Circle" and classes.get(f"{contact}.contour{3 - n}") != "HalfPlane":
            return f"; if one should be inside of the other, set `{solid}(inside=true)`"
    return ""


def _beyond(program: Program, name: str) -> tuple[str, str, str] | None:
    """Of a touch that is one of two stops: the coordinate, its limit, and which would be wider."""
    stops, _, side = name.rpartition(".")
    ending = {"lower": "_min", "upper": "_max"}.get(side, "?")
    for p in program.parameter_slots:
        if p.name.startswith(f"{stops}.") and p.name.endswith(ending):
            way = p.name.removesuffix(ending)
            if any(c.name == way for c in program.columns):
                return way, p.name, "smaller" if side == "lower" else "larger"
    return None


def begun_wrong(touches: Points, t: float) -> Diagnostic | None:
    """Why a run cannot begin: both contours of a contact are on one body."""
    owners = {n: touch.name.rpartition(".")[0] for n, touch in enumerate(touches.all)}
    alone = fixed_together(touches.program, dict.fromkeys(owners.values()))
    found = next((n for n, owner in owners.items() if owner == alone), None)
    return None if found is None or touches.bound[found] else one_body(touches, found, t)


def shared(touches: Points, some: Sequence[int], t: float) -> Diagnostic:
    """A note of touches at rest, of which fewer contacts could carry the same."""
    names = dict.fromkeys(f"`{contact_of(touches, i)}`" for i in some)
    message = (
        f"{listed(list(names))} carry at t = {t:.6g} s what fewer of them could: how they share it "
        "is not determined, and one of all ways is given"
    )
    hint = "let them yield (`law=Compliant`), if that is to be known"
    return replace(_found(touches, some[0], "R416", message, hint), severity=Severity.NOTE)


def one_body(touches: Points, i: int, t: float) -> Diagnostic:
    name, program = named(touches, i), touches.program
    message = f"the contours of {name} cannot move against each other"
    hint = "connect its frames to bodies that move against each other"
    met = bodies(program, touches.all[i].name)
    if len(met) == 1:
        message = f"both contours of {name} are fixed to {met[0]}"
    elif isinstance(touches, Touches) and (given := _given(touches, i)):
        message = f"at t = {t:.6g} s the contours of {name} meet, and neither can yield: {given}"
        hint = _YIELDS
    elif holder := _held_by(touches, i):
        message = f"{name} touches what `{holder}` holds there already"
        hint = f"leave `{holder}` out, or {name}"
    return _found(touches, i, "R481", message, hint)


def pinched(touches: Touches, some: Sequence[int], t: float) -> Diagnostic:
    """Of contacts between which motions that are given leave no room."""
    if len(some) == 1:
        return one_body(touches, some[0], t)
    names = [named(touches, i) for i in some]
    return without_room(touches, [touches.all[i].name for i in some], names, t)


def without_room(
    touches: Touches, components: Sequence[str], names: Sequence[str], t: float
) -> Diagnostic:
    """The same by the names of what meets; the first component is where that is told."""
    given = next(filter(None, (_given_at(touches, c) for c in components)), "")
    message = f"at t = {t:.6g} s {listed(names)} press against each other, and nothing can yield"
    part = own_part(touches.program, components[0])
    span = part.span if part else None
    return Diagnostic("R481", f"{message}{given and ': '}{given}", span, hint=_YIELDS)


def _held_by(touches: Points, i: int) -> str:
    """The joint that holds the two links of a contact beside it."""
    mechanism, component = touches.program.mechanism, touches.all[i].name
    while mechanism is not None and component:
        links = {
            n
            for n, link in enumerate(mechanism.links)
            if any(f.rpartition(".")[0] == component for f in link.frames)
        }
        if len(links) == 2:
            found = (j.name for j in mechanism.joints if set(j.links) == links)
            return next((n for n in found if not n.startswith(component)), "")
        component = component.rpartition(".")[0]
    return ""


def _given(touches: Touches, i: int) -> str:
    """The speeds that drives give to the joints around a contact."""
    return _given_at(touches, touches.all[i].name)


def _given_at(touches: Touches, component: str) -> str:
    while component:
        if joints := joints_of(touches.program, {component}):
            return given_of(touches.program, touches.kernel, joints, SPEEDS)
        component = component.rpartition(".")[0]
    return ""


def _friction(touches: Points, some: Sequence[int], mu: Vector | None) -> str:
    if mu is None:
        return listed([named(touches, i) for i in some])
    rubbing = [i for i in some if mu[i] > 0] or list(some)
    return listed([f"{named(touches, i)} (mu = {mu[i]:.4g})" for i in rubbing])


def no_impact(touches: Points, some: Sequence[int], mu: Vector | None, t: float) -> Diagnostic:
    """Without `mu` coefficients are not told."""
    message = f"no impulses end the impact at {_friction(touches, some, mu)} at t = {t:.6g} s"
    return _found(touches, some[0], "R482", message, "lower mu, or take the compliant law")


def no_forces(touches: Points, some: Sequence[int], mu: Vector | None, t: float) -> Diagnostic:
    rubbing, jam = _friction(touches, some, mu), "with so much friction rigid bodies jam"
    if touches.bound[list(some)].all():
        message = f"no forces hold {rubbing} at t = {t:.6g} s: {jam} while they slide"
        return _found(touches, some[0], "R482", message, "lower mu")
    message = f"no forces keep {rubbing} closed or open at t = {t:.6g} s: {jam} while they slide"
    return _found(touches, some[0], "R482", message, "lower mu, or take the compliant law")
