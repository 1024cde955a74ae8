"""The first content of an instance: the model put together here, at export.

In:   Compiled
Out:  Image   the start as a run finds it, its states, and the conditions that hold it

A model with loops has several assemblies. The one that `planarc simulate` finds is carried
along: an exported model begins in it, and looks for starts with other parameters from it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from planarc.core.data import Data
from planarc.core.diagnostic import PlanarcError
from planarc.core.options import RunOptions
from planarc.instance.plan import Lags
from planarc.ir.frame import Mode, place

if TYPE_CHECKING:
    from planarc.compiled import Compiled
    from planarc.ir.program import Program
    from planarc.solve.settings import Request


class Image(Data):
    """`held` are pairs (slot, slot of the value that it is held at); `system` is the table of
    `codegen.native.differences` for the conditions of the start. `timed` are relations that switch
    once, at a time known beforehand; `span` is the length of the experiment."""

    time: float
    selection: tuple[int, ...]
    states: tuple[float, ...]
    w: Any
    numbers: Any
    accepted: Any
    scales: Any
    bound: float
    held: tuple[tuple[int, int], ...]
    system: tuple[int, ...]
    timed: frozenset[int] = frozenset()
    span: float = 1.0
    stiff: bool = False  # the choice of steps
    lags: Lags | None = None  # room for the past of delayed signals
    step: float | None = None  # the length of steps, where there is a crowd


def take_image(compiled: Compiled) -> Image:
    """Begin a run. Raises PlanarcError where there is no start."""
    from planarc.solve.run import Run
    from planarc.solve.settings import resolve

    program, kernel = compiled.program, compiled.load()
    request = resolve(program, RunOptions())
    run = Run(program, kernel, request, str(compiled.backend))
    try:
        run.begin()
        if run.ended is not None:
            raise PlanarcError(run.ended)
        held = _held(program, run.held)
        memory: Any = kernel
        return Image(
            time=request.start,
            selection=tuple(run.states.selection),
            states=tuple(run.states.values()),
            w=memory.w.copy(),
            numbers=memory._numbers.copy(),
            accepted=memory._accepted.copy(),
            scales=run.states.watch.scales.copy(),
            bound=run.states.watch.bound,
            held=held,
            system=_system(program, tuple(slot for slot, _ in held)),
            timed=_timed(program, kernel, request.start),
            span=request.span,
            lags=_lags(program, kernel, request),
            step=run.integrator.last_step() if request.stepping else None,
        )
    finally:
        run.close()


def _lags(program: Program, kernel: Any, request: Request) -> Lags | None:
    """Room for as much as the delay times at export ask for."""
    if not program.delays:
        return None
    from planarc.export.delays import room_of
    from planarc.solve.messages.text import Reader

    read = Reader(program, kernel, request.start)
    times = (d.interval if d.interval_slot is None else d.maximum for d in program.delays)
    longest = min(max(float(read(t)) for t in times if t is not None), request.span)
    ticks = [float(read(interval)) for _, _, interval, _ in program.samplers]
    return room_of(program, longest, ticks, request.span / max(len(request.grid) - 1, 1))


def _timed(program: Program, kernel: Any, start: float) -> frozenset[int]:
    """The relations whose zero functions are lines over time."""
    from planarc.solve.events.instants import linear_zero, time_functions

    functions = time_functions(program, kernel, start)
    return frozenset(i for i, zero in functions.items() if linear_zero(zero) is not None)


def _held(program: Program, told: Any) -> tuple[tuple[int, int], ...]:
    """What was held at the start, and by which values."""
    count = len(program.candidates)
    pairs = [(c.slot, c.start) for c, h in zip(program.candidates, told, strict=False) if h.held]
    others = {h.name for h in told[count:] if h.held}
    pairs += [(f.slot, f.start) for f in program.fixed if f.fixed or f.display in others]
    return tuple(pairs)


def _system(program: Program, slots: tuple[int, ...]) -> tuple[int, ...]:
    placed = place(program)
    residuals = [
        placed.residuals(k) + i
        for k, code in enumerate(program.blocks)
        if code.height
        for i in range(len(code.residuals))
    ]
    moved = [c.slot for c in program.candidates]
    counts = (len(moved), len(residuals), len(program.initial_residuals), len(slots))
    return (int(Mode.GIVEN), *counts, *moved, *residuals, *slots)
