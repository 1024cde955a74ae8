"""Inverse dynamics: what it takes to move joints in a given way.

In:   Model, motions of joint coordinates over time
Out:  Driven    the run, and the effort (torque or force) of each driven joint

The model is compiled once more with the joint's own law replaced. A hinge says
`tau = 0`; driven, it says `phi = motion` instead, and tau is what that needs. A joint
with a driven flange keeps its law and gets a second drive beside it. Where all degrees
of freedom are driven nothing is left to integrate, and the equations are only solved.

A motion that is a text is compiled into the model. Any other is put in as

    motion(t) = q + v*(t - T) + a/2*(t - T)^2

whose parameters are set to position, velocity and acceleration at t = T before every
evaluation at T: exact, as no higher derivatives occur.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from planarc import compiler, stages
from planarc.api.analysis.driven_errors import ADDED, Motions
from planarc.api.result import Result, RunStopped
from planarc.api.signals import ForcedKernel, Motion, Signal, read_motion, table_span
from planarc.api.values import Value, start_values
from planarc.api.variant import variant_of
from planarc.compiled import Compiled
from planarc.core.arrays import Vector
from planarc.core.clock import Clock
from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError, Severity, usage_error
from planarc.core.options import RunOptions
from planarc.core.prose import ticked
from planarc.core.unknown import refuse_unknown, unknown_name
from planarc.evaluate.value import evaluate
from planarc.ir.dae import Dae, Equation
from planarc.ir.expr import Expr, symbols
from planarc.ir.kernel import Kernel
from planarc.ir.program import Let, Program
from planarc.request.request import open_target

if TYPE_CHECKING:
    from planarc.api.model import Model

#: The coordinate of a joint, and the effort that belongs to it.
EFFORTS = {"phi": "tau", "s": "f"}
#: Times at which a motion is looked at for a jump, halvings of the longest way, and the part of the
#: largest position that a jump is at least.
_TIMES, _HALVINGS, _SLIGHT = 200, 30, 1e-6


class Driven(Data):
    """A driven motion. `efforts` tells for each driven coordinate the variable that is its torque
    or force."""

    result: Result
    efforts: Mapping[str, str]

    def effort(self, coordinate: str | None = None) -> Vector:
        """The effort in N.m or N; without a name, of the only driven coordinate."""
        if coordinate is None and len(self.efforts) == 1:
            coordinate = next(iter(self.efforts))
        if coordinate is None or coordinate not in self.efforts:
            raise unknown_name("driven coordinate", coordinate, self.efforts)
        return self.result[self.efforts[coordinate]]

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.result)

    def __getitem__(self, name: str) -> Vector:
        """Any variable over `time`, as of a Result: its shape is (rows,). Raises UnknownName."""
        return self.result[name]

    @property
    def time(self) -> Vector:
        """The times of the rows, in s."""
        return self.result.time

    def _repr_html_(self) -> str:
        return self.result._repr_html_()


def drive(
    model: Model,
    motions: Mapping[str, Signal | str],
    options: RunOptions,
    parameters: Mapping[str, Value] | None,
    start: Mapping[str, Value] | None,
) -> Driven:
    """See `Model.drive`."""
    model, settable = model.with_parameters(parameters)
    coordinates = tuple(motions)
    efforts = {c: _effort(model.program, c) for c in coordinates}
    texts = tuple(m if isinstance(m, str) else None for m in motions.values())
    if (coordinates, texts) not in model.driven:
        made = _compile_driven(model, coordinates, efforts, texts)
        model.driven[coordinates, texts] = made
    compiled, efforts = model.driven[coordinates, texts]
    program = compiled.program
    given = program.experiment
    begin = given.start if options.start is None else options.start
    ends = [end for c, m in motions.items() if (end := table_span(c, m))]
    if options.stop is None and ends:  # a run lasts as long as its motion is known
        options = replace(options, stop=min(last for _, last in ends))
    stop = given.stop if options.stop is None else options.stop
    _refuse_unknown_times(motions, begin, stop)
    functions = {
        k: read_motion(c, m, stop - begin)
        for k, (c, m) in enumerate(motions.items())
        if not isinstance(m, str)
    }
    starts = start_values(program, start)
    for k, motion in functions.items():
        _refuse_jump(coordinates[k], motion, begin, stop)
        starts |= _start_at(program, coordinates[k], motion(begin))
    options = replace(options, values=settable, starts=starts)
    inner = compiled.load()
    kernel = ForcedKernel(inner, _force(program, inner, functions), begin)
    told = Motions(coordinates, texts)
    try:
        rows = compiler.run(compiled, options, kernel=kernel)
    except PlanarcError as problem:
        raise told.stopped(problem) from None
    rows = told.told_of_rows(rows)
    shown = tuple(c for c in program.columns if not c.name.startswith(ADDED))
    result = Result(replace(rows, program=replace(program, columns=shown)), compiled)
    if rows.ended is not None and rows.ended.severity is Severity.ERROR:
        raise RunStopped(rows.ended, result)
    return Driven(result, efforts)


def _refuse_unknown_times(motions: Mapping[str, Signal | str], begin: float, stop: float) -> None:
    for coordinate, motion in motions.items():
        first, last = table_span(coordinate, motion) or (begin, stop)
        slack = 1e-9 * (last - first)
        if begin < first - slack or stop > last + slack:
            raise usage_error(
                "C212",
                f"the motion of `{coordinate}` is known from {first:g} s to {last:g} s, and "
                f"the run goes from {begin:g} s to {stop:g} s",
                hint="give other times, or a longer table",
            )


def _refuse_jump(coordinate: str, motion: Motion, begin: float, stop: float) -> None:
    """Refuse a function whose position jumps: where it moves most between two of many times, that
    way does not get shorter with the time."""
    times = [begin + (stop - begin) * k / _TIMES for k in range(_TIMES + 1)]
    values = [motion(t)[0] for t in times]
    ways = [abs(b - a) for a, b in pairwise(values)]
    k = max(range(_TIMES), key=lambda i: ways[i])
    (first, last), (old, new) = times[k : k + 2], values[k : k + 2]
    for _ in range(_HALVINGS):
        middle = (first + last) / 2
        value = motion(middle)[0]
        if abs(value - old) > abs(new - value):
            last, new = middle, value
        else:
            first, old = middle, value
    if abs(new - old) > ways[k] / 2 and abs(new - old) > _SLIGHT * max(map(abs, values)):
        raise usage_error(
            "C217",
            f"the motion of `{coordinate}` jumps from {old:.4g} to {new:.4g} at t = {last:.4g} s, "
            "which no force can do",
            hint="let it pass there without a jump; angles are in rad",
        )


def _effort(program: Program, coordinate: Any) -> str:
    known = {c.name for c in program.columns}
    choices = [
        c for c in sorted(known)
        if EFFORTS.get(c.rpartition(".")[2])
        and f"{c.rpartition('.')[0]}.{EFFORTS[c.rpartition('.')[2]]}" in known
    ]  # fmt: skip
    if coordinate not in known:
        inside = [c for c in choices if c.startswith(f"{coordinate}.")]
        refuse_unknown("variable", (coordinate,), inside or known)
    joint, _, last = coordinate.rpartition(".")
    effort = f"{joint}.{EFFORTS.get(last, '')}"
    if effort in known:
        return effort
    raise usage_error(
        "C242",
        f"`{coordinate}` is no coordinate of a joint, so nothing can drive it",
        hint=f"choose among {ticked(choices[:8])}" if choices else None,
    )


def _start_at(
    program: Program, coordinate: str, motion: tuple[float, float, float]
) -> dict[str, float]:
    """The motion at the start as guesses, for what is still a candidate for a state."""
    slots = {c.slot for c in program.candidates}
    columns = {c.name: c.slot for c in program.columns}
    joint = coordinate.rpartition(".")[0]
    rate = {"phi": "w", "s": "v"}[coordinate.rpartition(".")[2]]
    wanted = ((coordinate, motion[0]), (f"{joint}.{rate}", motion[1]))
    return {n: v for n, v in wanted if columns.get(n) in slots}


def _force(program: Program, kernel: Kernel, functions: Mapping[int, Motion]) -> Any:
    """Values by slot at a time: the parameters of the motions, and what depends on them."""
    names = {k: [f"{ADDED}{k}{part}" for part in "qvaT"] for k in functions}
    moving = {name for found in names.values() for name in found}
    dependent: list[tuple[str, Expr]] = []
    for s in program.parameters:
        if isinstance(s, Let) and any(repr(e) in moving for e in symbols(s.value)):
            moving.add(repr(s.target))
            dependent.append((repr(s.target), s.value))
    slots = {name: program.slots[name] for name in sorted(moving) if name in program.slots}

    def values(t: float) -> dict[int, float]:
        found: dict[str, float] = {}
        for k, motion in functions.items():
            found.update(zip(names[k], (*motion(t), t), strict=True))

        def leaf(e: Expr) -> float:
            name = repr(e)
            return found[name] if name in found else float(kernel.w[program.slots[name]])

        for name, value in dependent:
            found[name] = float(evaluate(value, leaf))
        return {slot: found[name] for name, slot in slots.items()}

    return values


# Compiling ------------------------------------------------------------------------------------


def _compile_driven(
    model: Model,
    coordinates: Sequence[str],
    efforts: Mapping[str, str],
    texts: Sequence[str | None],
) -> tuple[Compiled, dict[str, str]]:
    """The model with motions in it, and the variable that holds each effort."""
    declarations = "\n".join(_declaration(k, text) for k, text in enumerate(texts))
    request = variant_of(model.request, None, declarations)
    given, of = Motions(coordinates, texts), model.program
    try:
        alone = stages.to_dae(stages.flatten(open_target(request)))
    except PlanarcError as problem:
        raise given.unreadable(problem) from None
    dae, found = _with_motions(alone, coordinates, efforts, texts)
    try:
        program, notes = compiler.find_program(dae, model.request.redundant, Clock())
    except PlanarcError as problem:
        mechanism = stages.find_mechanism(alone)
        raise given.unfit(problem, of, alone, mechanism) from None
    program = replace(program, name=of.name, description=of.description, experiment=of.experiment)
    code = stages.to_code(program, model.backend)
    return Compiled(program, model.backend, code, notes), found


def _declaration(k: int, text: str | None) -> str:
    name = f"{ADDED}{k}"
    if text is not None:
        return f"  Real {name} = {text};"
    parameters = ", ".join(f"{name}{part} = 0" for part in "qvaT")
    since = f"(time - {name}T)"
    formula = f"{name}q + {name}v*{since} + {name}a/2*{since}^2"
    return f"  parameter Real {parameters};\n  Real {name} = {formula};"


def _with_motions(
    dae: Dae,
    coordinates: Sequence[str],
    efforts: Mapping[str, str],
    texts: Sequence[str | None],
) -> tuple[Dae, dict[str, str]]:
    """The equations with motions in the place of joints' laws; nothing is fixed at the start."""
    followed = {k: e for k, t in enumerate(texts) if t is not None and (e := _followed(dae, k))}
    inside = {f"{ADDED}{k}" for k in followed}
    equations = [e for e in dae.equations if not any(e is f for f in followed.values())]
    variables = [
        replace(v, fixed=False, start_written=v.start_written or v.fixed)
        for v in dae.variables
        if v.name not in inside
    ]
    found: dict[str, str] = {}
    for k, coordinate in enumerate(coordinates):
        effort = efforts[coordinate]
        symbol, motion = dae.table.symbol(coordinate), dae.table.symbol(f"{ADDED}{k}")
        driving: dict[str, Any] = {"left": symbol, "right": motion}
        if k in followed:
            # It is no law of the joint's, which still moves.
            given = followed[k]
            driving |= {"right": given.right, "span": given.span, "component": ""}
        law = _law(dae, equations, effort)
        if law is not None:
            equations[law] = replace(equations[law], **driving)
            found[coordinate] = effort
            continue
        at = _definition(dae, equations, effort)
        if at is None:
            raise usage_error("C247", f"nothing more can drive `{coordinate}`: `{effort}` is given")
        added = f"{effort}_drive"
        while any(v.name == added for v in variables):
            added += "_"
        like = next(v for v in variables if v.name == effort)
        variables.append(replace(like, name=added, description="Effort of the motion", start=None))
        both = dae.table.add(equations[at].left, dae.table.symbol(added))
        equations.append(replace(equations[at], **driving))
        equations[at] = replace(equations[at], left=both)
        found[coordinate] = added
    return replace(dae, equations=tuple(equations), variables=tuple(variables)), found


def _followed(dae: Dae, k: int) -> Equation | None:
    """The equation that gives the motion of a text its value."""
    symbol = dae.table.symbol(f"{ADDED}{k}")
    return next((e for e in dae.equations if e.left is symbol), None)


def _law(dae: Dae, equations: Sequence[Equation], effort: str) -> int | None:
    """The equation `effort = 0`."""
    symbol, zero = dae.table.symbol(effort), dae.table.const(0.0)
    for i, e in enumerate(equations):
        if (e.left is symbol and e.right is zero) or (e.left is zero and e.right is symbol):
            return i
    return None


def _definition(dae: Dae, equations: Sequence[Equation], effort: str) -> int | None:
    """The equation that says how the effort acts: `tau = -frame_b.t`."""
    symbol = dae.table.symbol(effort)
    joint = effort.rpartition(".")[0]
    for i, e in enumerate(equations):
        if e.component == joint and e.left is symbol and not e.generated:
            return i
    return None
