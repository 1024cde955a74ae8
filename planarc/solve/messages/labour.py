"""Stretches of a run that take absurdly many steps, and the jump in the equations they stand at.

In:   Program, Kernel, the point where each long stretch ends
Out:  a warning, once the run is over; an error, where nobody would wait for its end

An integrator that meets `sign(v)` where v comes to rest crosses the jump to and fro, by steps as
short as its tolerance: the result is right, and takes millions of them. A jump is told where its
switching value lies within what the states are known to.

Example: `der(v) = -2*sign(v)` from v = 1: from t = 0.5 s on v = 0 up to 1e-6.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Laborious, Severity
from planarc.ir.expr import Expr, Op, brief, postorder
from planarc.ir.kernel import Kernel
from planarc.ir.program import EquationInfo, Let, Program, Solve
from planarc.solve import effort
from planarc.solve.messages import trouble

#: Long stretches at a jump, and others that are absurd, from which on one warns.
JUMPING, ABSURD = 10, 100
#: Stretches in a row at a jump, each at most so much of the run, after which it is ended: at this
#: pace it would take 100 million steps.
HOPELESS, HOPELESS_PART = 100, 1e-4
#: Stretches without a jump after which none is looked for any more.
PLAIN = 30
#: Multiple of its change, where states move by their tolerances, that is a switching value.
NEAR = 10.0
_STICKING = (
    "use a part that sticks and slips by events, as `BearingFriction` of "
    "`Modelica.Mechanics.Rotational.Components` or `SupportFriction` of "
    "`Modelica.Mechanics.Translational.Components`, or make the jump smooth, as `tanh(v/v_small)`"
)
_FAST = "slow down what is fast: a very stiff spring may be a rigid part"


class Jump(Data):
    """An expression that jumps, or has a kink, where its `sides` are equal, or one is zero."""

    text: str
    sides: tuple[Expr, ...]
    info: EquationInfo


class Stretch(Data):
    """Many steps in a row: from when to when, and the states at the end, with their tolerances."""

    begin: float
    t: float
    names: Sequence[str]
    y: Sequence[float]
    sizes: Sequence[float]
    absurd: bool  # whatever the reason


class Labour:
    """The long stretches of one run, those at a jump counted for each."""

    def __init__(self, program: Program, kernel: Kernel, span: float) -> None:
        self._program, self._kernel, self._span = program, kernel, span
        self._jumps: tuple[Jump, ...] | None = None
        self._counts: Counter[int] = Counter()
        self._stretches = self._absurd = self._hopeless = 0
        self._first = self._last = 0.0  # where the first began, and the last ended
        self._fastest = ""

    def note(self, stretch: Stretch) -> Diagnostic | None:
        """Why the run ends after this long stretch, if it does. The workspace is left at
        another point than its end."""
        self._first = self._first if self._stretches else stretch.begin
        self._last = stretch.t
        self._stretches += 1
        self._absurd += stretch.absurd
        if self._stretches <= PLAIN or self._counts:
            ydot = [0.0] * len(stretch.y)
            if self._kernel.rhs(stretch.t, stretch.y, ydot) == 0:
                self._fastest = trouble.fastest(stretch.names, stretch.y, ydot)
            self._counts.update(found := self._at(stretch))
            way = stretch.t - stretch.begin
            slow = bool(found) and way <= HOPELESS_PART * self._span
            self._hopeless = self._hopeless + 1 if slow else 0
            if self._hopeless == HOPELESS:
                steps = effort.STRETCH * self._span / way
                message = f"from t = {self._first:.4g} s on the run would take "
                message += f"{steps / 1e6:,.0f} million steps"
                return self._diagnostic(message, Severity.ERROR)
        return None

    def _at(self, stretch: Stretch) -> list[int]:
        """The jumps whose switching values are zero there, as far as one knows the states."""
        if self._jumps is None:
            self._jumps = tuple(_jumps(self._program))
        points = _around(stretch.y, stretch.sizes)
        here, *moved = (self._switches(stretch.t, point) for point in points)
        ways = [max(abs(m - v) for m in found) for v, *found in zip(here, *moved, strict=True)]
        return [i for i, way in enumerate(ways) if way > 0 and abs(here[i]) <= NEAR * way]

    def _switches(self, t: float, y: Sequence[float]) -> list[float]:
        """What is zero where each of the jumps is."""
        self._kernel.rhs(t, y, [0.0] * len(y))
        from planarc.solve.messages.replay import Replay

        replay = Replay(self._program, self._kernel, t)
        sides = [replay.values(jump.sides) for jump in self._jumps or ()]
        return [v[0] - (v[1] if len(v) > 1 else 0.0) for v in sides]

    def warning(self) -> Diagnostic | None:
        """What one should know of the steps of a run that was not ended for them."""
        enough = self._often() or self._absurd >= ABSURD
        if not enough or self._hopeless == HOPELESS:
            return None
        message = f"between t = {self._first:.4g} s and t = {self._last:.4g} s the run took "
        message += f"{effort.STRETCH * self._stretches:,} steps"
        return self._diagnostic(message, Severity.WARNING)

    def _often(self) -> list[int]:
        """The jumps at which many of the stretches stood."""
        return [i for i, n in self._counts.items() if n >= max(JUMPING, self._stretches // 10)]

    def _diagnostic(self, message: str, severity: Severity) -> Diagnostic:
        hint, span = _FAST, None
        if (often := self._often()) and self._jumps is not None:
            hint = _STICKING
            jump = self._jumps[max(often, key=lambda i: (self._counts[i], -i))]
            message += f": {jump.text} in `{jump.info.text}` switches to and fro there"
            span = jump.info.span
        if self._fastest:
            hint += f"; the states that move fastest are {self._fastest}"
        return Laborious("R427", message, span, severity, hint=hint)


def _around(y: Sequence[float], sizes: Sequence[float]) -> Iterator[list[float]]:
    """A point and two beside it, each state moved by its size."""
    yield list(y)
    for turn in (0.3, 0.7):
        signs = [1 if (k * 0.618 + turn) % 1.0 < 0.5 else -1 for k in range(len(y))]
        yield [v + s * d for v, s, d in zip(y, signs, sizes, strict=True)]


def _jumps(program: Program) -> Iterator[Jump]:
    """Everything that jumps without an event, in the equation where it stands first."""
    lets: list[Let] = []
    for statement in (s for level in program.levels for s in level):
        own = program.blocks[statement.block].body if isinstance(statement, Solve) else (statement,)
        lets.extend(let for let in own if isinstance(let, Let))
    seen: set[Expr] = set()
    waiting: dict[Expr, list[Expr]] = {}  # what stands in temporaries, which no equation names
    for let in lets:
        nodes = list(postorder((let.value,)))
        found = [e for e in nodes if _sides(e) and e not in seen]
        found += [e for n in nodes for e in waiting.get(n, ())]
        seen.update(found)
        if let.equation is None:
            waiting[let.target] = found
            continue
        for e in dict.fromkeys(found):
            info = program.equations[let.equation]
            yield Jump(_told(e, info), _sides(e), info)


def _told(e: Expr, info: EquationInfo) -> str:
    """The expression as it is written; where other names stand in its place, its kind."""
    if (found := brief(e)) in info.text:
        return f"`{found}`"
    return f"`{e.data}`" if e.op is Op.CALL else "a relation without event"


def _sides(e: Expr) -> tuple[Expr, ...]:
    """What must be equal, or be zero, where an expression jumps or has a kink."""
    if e.op in (Op.LESS, Op.LESS_EQUAL) or (e.op is Op.CALL and e.data in ("sign", "abs")):
        return e.args
    return ()
