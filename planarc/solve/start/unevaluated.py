"""Why equations have no value at the start, or no solution, in words: what divides by zero, what
has no mass.

In:   System, the flag of its evaluation
Out:  NotEvaluated    R413, or R410 for a block of equations
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.core.diagnostic import Diagnostic, Explained, PlanarcError
from planarc.core.prose import both
from planarc.ir.expr import Op, postorder
from planarc.ir.kernel import Kernel, changed
from planarc.ir.mechanism import GROUND
from planarc.ir.places import owner, point_home
from planarc.ir.program import BlockCode, EquationInfo, Let, Program
from planarc.ir.sparse import entries_of
from planarc.solve.messages import trouble
from planarc.solve.messages.assertion import broken_assertion
from planarc.solve.messages.slides import one_way
from planarc.solve.rescue.rescue import Account
from planarc.solve.start.system import System

_WORST = 3
#: The least singular value, as a part of the largest, of equations that have a solution.
_REGULAR = 1e-9


class NotEvaluated(PlanarcError):
    """The equations have no value, or no solution, at the start (R413, R410)."""


def not_evaluated(system: System, flag: int) -> PlanarcError:
    """The equations have no value at the start."""
    kernel = system.kernel
    if kernel.failed_block >= 0 and kernel.failed_equation < 0:
        return _block_failed(system, kernel.failed_block)
    where = trouble.first_not_finite(system.program, kernel, system.t)
    said = broken_assertion(system.program, kernel, system.t, where.component) if where else None
    if said is not None:
        return NotEvaluated(said)
    message = f"the model cannot be evaluated at its start, t = {system.t:g} s"
    if where is not None:
        place = f" in `{where.component}`" if where.component else ""
        message += f": `{where.text}`{place} gives no finite number"
    found = Diagnostic(
        "R413",
        message,
        where.span if where else None,
        hint=(_zeros(system, [where], divisors=True) if where else None)
        or "check parameters and start values for a division by zero or a root of a "
        "negative number",
    )
    return NotEvaluated(point_home(system.program, found, where.component if where else ""))


def _block_failed(system: System, block: int) -> PlanarcError:
    program = system.program
    tried = system.rescue.account(system.t, block)
    worst = trouble.worst_equations(program, system.kernel, system.t, block, _WORST)
    if tried is not None:
        worst = list(tried.worst)
    infos = [i for _, i in worst]
    every = [program.equations[e] for e in program.blocks[block].equations]
    alone = program.mechanism is None and program.blocks[block].linear
    names = trouble.components(program, every if alone else infos)
    locked = program.mechanism.locked if program.mechanism else None
    row = None if locked else _in_a_row(program, every)
    row = row or one_way(program, system.kernel, [i.component for i in infos]) or None
    massless = None if locked or row else _massless(system, block)
    home = (owner(massless) if massless else "") or (infos[0].component if infos else "")
    found = (Explained if massless else Diagnostic)(
        "R410",
        f"the equations of {names} cannot be solved at the start, t = {system.t:g} s"
        if names
        else f"a system of equations cannot be solved at the start, t = {system.t:g} s",
        infos[0].span if infos else None,
        hint=_zeros(system, infos)
        or (f"{locked.message}; {locked.hint}" if locked else None)
        or row
        or (_without_inertia(program, system.kernel, massless) if massless else None)
        or _advice(program, every, tried, program.blocks[block].linear),
        related=trouble.related(worst),
    )
    return NotEvaluated(point_home(program, found, home))


def _zeros(system: System, infos: Sequence[EquationInfo], divisors: bool = False) -> str | None:
    """The parameters in equations that are zero, with which these may lose their unknowns; without
    one the variables that start at 0 as no start value is written. Of divisors only, if asked."""
    if system.program.mechanism is not None and not divisors:
        return None
    w = system.kernel.w
    values = {p.name: float(w[p.slot]) for p in system.program.parameter_slots}
    slots = (c for c in system.program.candidates if not c.start_written and not c.fixed)
    starts = {c.name: float(w[c.slot]) for c in slots}
    sides = [e for i in infos if not isinstance(i.written, str) for e in i.written]
    if divisors:
        sides = [e.args[1] for e in postorder(sides) if e.op is Op.DIV]
    symbols = dict.fromkeys(repr(e) for e in postorder(sides) if e.op is Op.SYMBOL)
    names = [n for n in symbols if values.get(n) == 0.0]
    verb = "is" if len(names) == 1 else "are"
    if names:
        return f"{trouble.names(names)} {verb} 0: give another value"
    names = [n for n in symbols if starts.get(n) == 0.0]
    verb, pronoun = ("starts", "it") if len(names) == 1 else ("start", "them")
    if not names:
        return None
    return (
        f"{trouble.names(names)} {verb} at 0, since no start value is written: give {pronoun} one, "
        f"as in `{names[0].rpartition('.')[2]}(start=1, fixed=true)`"
    )


def _in_a_row(program: Program, infos: Sequence[EquationInfo]) -> str | None:
    """What to do about two joints with nothing between them, of which one has no part to move."""
    mechanism, components = program.mechanism, {i.component for i in infos}
    if mechanism is None:
        return None
    for number, link in enumerate(mechanism.links):
        joints = [j.name for j in mechanism.joints if number in j.links]
        alone = number != GROUND and {*joints}.issuperset(map(owner, link.frames))
        if alone and len(joints) > 1 and components.issuperset(joints):
            hint = "put a body with mass there, or leave one of them out"
            return f"nothing with mass is between {both(joints)}: {hint}"
    return None


def _massless(system: System, block: int) -> str | None:
    """The parameter of 0 with another value of which a linear block had a solution: an inertia."""
    import numpy as np

    program, kernel = system.program, system.kernel
    code = program.blocks[block]
    if not code.linear:
        return None

    def regular() -> bool:
        matrix = np.array(kernel.jacobian(block), dtype=float)
        if not matrix.size or not np.all(np.isfinite(matrix)):
            return False
        sizes = np.linalg.svd(matrix, compute_uv=False)
        return bool(sizes[-1] > _REGULAR * sizes[0])

    components = {program.equations[e].component for e in code.equations}
    asked = _parameters_of(program, code)
    found: list[str] = []
    if regular():
        return None
    for parameter in program.parameter_slots:
        near = owner(parameter.name) in components or parameter.name in asked
        if not near or kernel.w[parameter.slot] != 0.0:
            continue
        with changed(kernel, {parameter.slot: 1.0}):
            if regular():
                found.append(parameter.name)
    return next((n for n in found if not n.endswith("]")), None)  # entries of vectors are lengths


def _without_inertia(program: Program, kernel: Kernel, name: str) -> str:
    """What to do about a parameter of 0; of an inertia whose mass is on the axis of a hinge, that
    a rod may have been forgotten."""
    component = owner(name)
    links = program.mechanism.links if program.mechanism else ()
    joints = {joint.name for joint in program.mechanism.joints} if program.mechanism else set()
    places = {c.name: c.slot for c in program.columns}
    centre = [p for p in program.parameter_slots if p.name.startswith(f"{component}.r_CM[")]
    mass = [p for p in program.parameter_slots if p.name == f"{component}.m"]
    aside = any(kernel.w[p.slot] != 0 for p in centre) or not any(kernel.w[p.slot] for p in mass)
    for link in links:
        own = [f for f in link.frames if owner(f) == component]
        if not own or not name.endswith(".I") or aside:
            continue
        here = places.get(f"{own[0]}.r[1]")
        hinges = [owner(f) for f in link.frames if places.get(f"{f}.r[1]") == here]
        hinges = [h for h in dict.fromkeys(hinges) if h in joints]
        if hinges:
            return (
                f"`{name}` is 0, and its mass is on the axis of `{hinges[-1]}` itself: put a rod "
                "between them, or give it a value"
            )
    return f"`{name}` is 0: give it a value"


def _parameters_of(program: Program, code: BlockCode) -> set[str]:
    """The names from which the slopes of a block follow without other blocks."""
    lets = (s for s in program.parameters if isinstance(s, Let))
    given = {repr(let.target): let.value for let in (*lets, *code.body, *code.jacobian_body)}
    waiting = [slope for *_, slope in code.jacobian]
    waiting += () if code.direct is None else entries_of(code.direct)
    found: set[str] = set()
    while waiting:
        for name in (repr(e) for e in postorder((waiting.pop(),)) if not e.args):
            if name not in found:
                found.add(name)
                waiting += [given[name]] if name in given else []
    return found


def _advice(
    program: Program, infos: Sequence[EquationInfo], tried: Account | None, linear: bool
) -> str:
    mechanism = program.mechanism
    links = mechanism.links if mechanism else ()
    moving = {owner(frame) for link in links for frame in link.frames}
    if mechanism and not (infos and moving.isdisjoint(info.component for info in infos)):
        return (
            "look for a part without mass that nothing holds, a joint that constrains what "
            "another one constrains already, or a stretched (singular) position"
        )
    if tried is None and linear:
        return (
            "an unknown cancels out of these equations: look for a signal that is led back to "
            "itself, or for what is decided twice"
        )
    if tried is None:
        return "check whether these equations have a solution, or give start values near to it"
    return (
        f"check whether these equations have a solution, or give start values near to it: {tried}"
    )
