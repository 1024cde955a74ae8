"""Errors of rounding in the zero functions, bounded statement by statement.

In:   Program, Kernel, its workspace at a point
Out:  for each zero function the size up to which it may be nothing but rounding

Every operation errs by the last digit of its result and passes on the errors of what it takes.
What is given, and discrete, is exact. The unknowns x of a block err as far as its equations
are missed there:

    |x - x*| <= |J^-1| (|r(x)| + error of r(x))

A state errs by its last digit, and by as much as its derivative may have erred since the start:
what is at rest by the equations creeps on their rounding.

Example: the shafts behind an open clutch are at rest, and one block solves for all
accelerations. Beside others of size 10, theirs are 1e-15 or 0, and so is what the relations of
the clutch compare.

Reference: N. J. Higham, Accuracy and Stability of Numerical Algorithms, SIAM 2002,
           sections 3.3 (running errors) and 7.1 (residuals).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from sys import float_info
from typing import TYPE_CHECKING, Any

from planarc.core.data import Data
from planarc.evaluate.operations import VALUES
from planarc.evaluate.value import apply_function, evaluate
from planarc.ir.expr import Expr, Op
from planarc.ir.kernel import Kernel
from planarc.ir.once import once
from planarc.ir.program import BlockCode, Program, Solve, Statement
from planarc.runtime import elementary

if TYPE_CHECKING:
    from planarc.evaluate.tape import Prepared

EPSILON = float_info.epsilon
#: What is read of a formula that Python cannot evaluate errs by so much of itself.
UNKNOWN = 1e-14
#: Errors of derivatives reach states, these derivatives of others, and so on: so many times.
PASSES = 3
#: Formulas that are asked for so often are prepared: that costs as much as asking so many times.
OFTEN = 20


class Rough:
    """A number, and how far it may be wrong."""

    __slots__ = ("error", "value")

    def __init__(self, value: float, error: float = 0.0) -> None:
        self.value, self.error = value, error

    def __add__(self, other: Any) -> Rough:
        b = _rough(other)
        total = self.value + b.value
        last = EPSILON * abs(total) if self.value and b.value else 0.0
        return Rough(total, self.error + b.error + last)

    def __mul__(self, other: Any) -> Rough:
        b = _rough(other)
        product = self.value * b.value
        passed = abs(self.value) * b.error + self.error * (abs(b.value) + b.error)
        last = 0.0 if 1 in (abs(self.value), abs(b.value)) else EPSILON * abs(product)
        return Rough(product, passed + last)

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> Rough:
        return Rough(-self.value, self.error)

    def __truediv__(self, other: Any) -> Rough:
        return _moved(lambda a, b: a / b, (self, other))

    def __rtruediv__(self, other: Any) -> Rough:
        return _moved(lambda a, b: a / b, (other, self))

    def __pow__(self, other: Any) -> Rough:
        return _moved(VALUES[Op.POW], (self, other))

    def __rpow__(self, other: Any) -> Rough:
        return _moved(VALUES[Op.POW], (other, self))

    def __lt__(self, other: Any) -> bool:
        return self.value < _rough(other).value

    def __le__(self, other: Any) -> bool:
        return self.value <= _rough(other).value

    def __gt__(self, other: Any) -> bool:  # what `<` asks of the right side, if that is rough
        return self.value > _rough(other).value

    def __ge__(self, other: Any) -> bool:
        return self.value >= _rough(other).value

    def __eq__(self, other: object) -> bool:
        return self.value == _rough(other).value

    def __bool__(self) -> bool:
        return self.value != 0


def _rough(value: Any) -> Rough:
    return value if isinstance(value, Rough) else Rough(float(value))


def _moved(function: Callable[..., float], arguments: Iterable[Any], steps: bool = False) -> Rough:
    """The value of a function, and how it moves when each argument moves by its error."""
    given = [_rough(a) for a in arguments]
    values = [a.value for a in given]
    value = float(function(*values))
    chosen = steps or abs(value) in map(abs, values)  # one of the arguments, as `min` gives it
    error = 0.0 if chosen else EPSILON * abs(value)
    for i, a in enumerate(given):
        if a.error and not steps:
            error += max(_distance(function, values, i, s * a.error, value) for s in (-1, 1))
    return Rough(value, error)


def _distance(
    function: Callable[..., float], values: Sequence[float], i: int, by: float, value: float
) -> float:
    try:
        return abs(function(*values[:i], values[i] + by, *values[i + 1 :]) - value)
    except (ArithmeticError, ValueError):  # beyond the edge of its domain
        return 0.0


class Formulas(Data):
    """Formulas of a program, in all its runs: those that are prepared, and how often others were
    asked for. Temporaries have places below zero."""

    prepared: dict[Expr, Prepared]
    times: dict[Expr, int]
    places: dict[Expr, int]


@once
def _formulas(program: Program) -> Formulas:
    return Formulas({}, {}, {})


def _called(e: Expr, arguments: Sequence[Any]) -> Rough:
    """A function of an expression, of rough numbers; one of steps is flat between them."""
    steps = e.op is Op.CALL and elementary.TABLE[e.data].slopes is None
    return _moved(lambda *values: apply_function(e, values), arguments, steps)


def _rough_function(e: Expr) -> Callable[..., Rough]:
    return lambda *arguments: _called(e, arguments)


class Rounding:
    """The errors of a kernel's values, by their slots."""

    def __init__(self, program: Program, kernel: Kernel) -> None:
        self._program, self._kernel = program, kernel
        self._formulas = _formulas(program)
        self._slots: dict[Expr, int | None] = {}
        self._errors: dict[int, float] = {}
        self._temporaries: dict[int, Rough] = {}  # by their places

    def bounds(self, elapsed: float) -> list[float]:
        """The errors of the zero functions at the workspace's point, `elapsed` since the start."""
        program, w = self._program, self._kernel.w
        states = [program.candidates[i] for i in self._kernel.selection]
        drift = [0.0] * len(states)
        for _ in range(PASSES):
            self._temporaries.clear()
            self._errors = {
                c.slot: EPSILON * abs(float(w[c.slot])) + d
                for c, d in zip(states, drift, strict=True)
            }
            for level in program.levels:
                self._run(level)
            before = drift
            drift = [self._errors.get(c.derivative, 0.0) * elapsed for c in states]
            if drift == before:
                break
        self._run(program.roots)
        return [self._leaf(relation.zero).error for relation in program.relations]

    def _run(self, statements: Iterable[Statement]) -> None:
        for s in statements:
            if isinstance(s, Solve):
                self._solve(s.block)
                continue
            slot = self._slot(s.target)
            try:
                found = _rough(self._value(s.value))
            except (ArithmeticError, ValueError, LookupError):
                value = float(self._kernel.w[slot]) if slot is not None else 1.0
                found = Rough(value, UNKNOWN * abs(value))
            if slot is None:
                self._temporaries[self._place(s.target)] = found
            else:
                self._errors[slot] = found.error

    def _solve(self, block: int) -> None:
        """The errors of a block's unknowns: of its tears, and of what follows from these."""
        code = self._program.blocks[block]
        slots = [self._slot(tear) for tear in code.tears]
        chosen = self._kernel.selection if code.height else ()
        tears = [j for j in range(len(slots)) if code.first + j not in chosen]
        if tears:
            import numpy as np

            matrix = np.array(self._kernel.jacobian(block))
            self._errors.update((slots[j] or 0, 0.0) for j in tears)
            missed = [abs(r.value) + r.error for r in self._residuals(code, matrix)]
            try:
                inverse = np.linalg.inv(matrix[:, tears])
            except np.linalg.LinAlgError:
                inverse = np.linalg.pinv(matrix[:, tears])
            found = (np.abs(inverse) @ missed).tolist()
            self._errors.update((slots[j] or 0, e) for j, e in zip(tears, found, strict=True))
        self._run(code.body)

    def _residuals(self, code: BlockCode, matrix: Any) -> list[Rough]:
        """The residuals of a block at its tears as they are."""
        if code.linear and code.direct is None:
            entries = [[Rough(a, EPSILON * abs(a)) for a in row] for row in matrix.tolist()]
            x = [self._leaf(tear) for tear in code.tears]
            return [
                _rough(sum((a * b for a, b in zip(row, x, strict=True)), self._leaf(r)))
                for row, r in zip(entries, code.residuals, strict=True)
            ]
        self._run(code.body)
        return [_rough(self._value(r)) for r in code.residuals]

    def _value(self, root: Expr) -> Any:
        """The value of an expression; ArithmeticError, ValueError or LookupError without one."""
        if not root.args:
            return self._leaf(root)
        known = self._formulas
        prepared = known.prepared.get(root)
        if prepared is None:
            times = known.times[root] = known.times.get(root, 0) + 1
            if times < OFTEN:
                return evaluate(root, self._leaf, _called)
            from planarc.evaluate.tape import prepare

            prepared = known.prepared[root] = prepare(root, self._place, _rough_function)
        return prepared(self, self[0])  # type: ignore[arg-type]

    def _slot(self, e: Expr) -> int | None:
        if e not in self._slots:
            self._slots[e] = self._program.slots.get(repr(e))
        return self._slots[e]

    def _place(self, e: Expr) -> int:
        """The slot of a leaf; below zero that of a temporary."""
        slot = self._slot(e)
        places = self._formulas.places
        return places.setdefault(e, -1 - len(places)) if slot is None else slot

    def _leaf(self, e: Expr) -> Rough:
        """A leaf's value; LookupError where it has none of its own."""
        if e.op is Op.CONST:
            return _rough(e.data)
        return self[0 if e.op is Op.TIME else self._place(e)]

    def __getitem__(self, place: int) -> Rough:
        """The value at a place; LookupError where there is none."""
        if place < 0:
            return self._temporaries[place]
        value = float(self._kernel.w[place])
        return Rough(value, self._errors.get(place, 0.0) if place else EPSILON * abs(value))
