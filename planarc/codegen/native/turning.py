"""Sine and cosine of angles that Newton's method moves a little, in LLVM.

Each step of Newton's method asks for both of every angle of a loop, and so does what stands behind
the block. From one step to the next an angle moves by less than `NEAR`, so that its sine and
cosine follow from those of the step before by the addition theorems, in a third of the time:

    sin(x + d) = s + (c*sin d - s*(1 - cos d))     sin d = d - d^3/6,   1 - cos d = d^2/2
    cos(x + d) = c - (s*sin d + c*(1 - cos d))

What is left out of the series is less than d^4/24, a tenth of the rounding of the result. An
evaluation begins with angles that are not numbers: nothing comes from the one before.
"""

from __future__ import annotations

from typing import Final

from planarc.codegen.native.assembly import REAL, Code, Value
from planarc.codegen.native.waves import call_waves
from planarc.ir.expr import Expr, Op
from planarc.ir.once import once
from planarc.ir.program import BlockCode, Let, Program

#: Places in the memory of an angle, and how many there are.
ANGLE, SINE, COSINE, NUMBERS = 0, 1, 2, 3
#: Radians up to which an angle is turned.
NEAR: Final = 1e-4

#: Tears of a block up to which its angles are turned.
FEW_TEARS: Final = 6
#: Angles of a program up to which they are turned behind their blocks, too.
FEW_ANGLES: Final = 12


def is_turn(e: Expr) -> bool:
    return e.op is Op.CALL and e.data in ("sin", "cos") and e.args[0].op is Op.SYMBOL


def angles(code: BlockCode) -> list[Expr]:
    """The angles whose sines and cosines each step of Newton's method asks for; none of a large
    block, whose statements become loops."""
    if code.linear or not code.residuals or len(code.tears) > FEW_TEARS:
        return []
    found = (s.value.args[0] for s in code.body if isinstance(s, Let) and is_turn(s.value))
    return list(dict.fromkeys(found))


@once
def are_few(program: Program) -> bool:
    return sum(map(len, map(angles, program.blocks))) <= FEW_ANGLES


def turn(c: Code, memory: Value, x: Value, fused: bool = False) -> dict[str, Value]:
    """Sine and cosine of an angle, which becomes that of the memory. `fused`: for a processor that
    needs no library for them (`waves`)."""
    near, far, behind = c.label(), c.label(), c.label()
    d, s, k = x - memory.load(REAL, ANGLE), memory.load(REAL, SINE), memory.load(REAL, COSINE)
    c.branch(c.absolute(d) < NEAR, near, far)
    c.begin(near)
    square = d * d
    across, along = d - d * square * (1 / 6), square * 0.5
    turned = s + (k * across - s * along), k - (s * across + k * along)
    c.jump(behind)
    c.begin(far)
    computed = call_waves(c, x) if fused else [c.call(REAL, name, x) for name in ("sin", "cos")]
    c.enter(behind)
    both = (c.joined((a, near), (b, far)) for a, b in zip(turned, computed, strict=True))
    sine, cosine = list(both)
    for place, value in ((ANGLE, x), (SINE, sine), (COSINE, cosine)):
        memory.store(value, place)
    return {"sin": sine, "cos": cosine}
