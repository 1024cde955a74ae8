"""Blocks that Newton's method of a kernel cannot solve from where it starts them.

In:   Program, Kernel after a call that failed, the call
Out:  the flag of the call once more, with the block started from a root of its own; notes

The root is found by one of the ways of `ladder` over the same residuals, and only one from
which the kernel itself gets on is taken: what is accepted is always the kernel's solution.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Severity
from planarc.core.prose import listed
from planarc.ir.expr import text
from planarc.ir.kernel import Kernel
from planarc.ir.program import EquationInfo, Let, Program

if TYPE_CHECKING:
    from planarc.core.arrays import Vector

#: Blocks that may stay unsolved in one run before no further ways are tried.
MOST_FAILURES = 8


class Rescue:
    """The rescue of one kernel's blocks. `notes` tell which way was taken, once for each block at
    the start and once on the way; `tried` are the blocks for which none was found, `leapt` are
    the equations of the last one that was solved anew, and `moved` is how far."""

    def __init__(self, program: Program, kernel: Kernel) -> None:
        self.program, self.kernel = program, kernel
        self.notes: dict[tuple[int, bool], Diagnostic] = {}
        self.tried: set[int] = set()
        self.leapt: tuple[str, ...] = ()
        self.moved = 0.0
        self.begun = False
        self.resting = False  # True where another root than the nearest would be no help
        self._left = MOST_FAILURES

    def overcome(self, t: float, call: Callable[[], int]) -> int:
        """The flag of a call of the kernel, with the help that blocks of the top need."""
        flag = call()
        for _ in self.program.blocks:
            block = self._failed() if flag else -1
            if block < 0 or self.resting:
                break
            flag = self._climb(t, block, call)
            if block in self.tried:
                break
        return flag

    def _failed(self) -> int:
        """The block that failed, where there are further ways for it, or -1."""
        block, program = self.kernel.failed_block, self.program
        if block < 0:
            block = _block_of(program, self.kernel.failed_equation)
        if block < 0 or not self._left:
            return -1
        code = program.blocks[block]
        return -1 if code.height or code.linear or not code.residuals else block

    def _climb(self, t: float, block: int, call: Callable[[], int]) -> int:
        import numpy as np

        from planarc.solve.rescue.ladder import climb

        guess = np.array(self.kernel.origin(block))
        if self.begun and self._beside(t, block, guess, call):
            return 0
        with np.errstate(all="ignore"):
            for found in climb(BlockFunction(self.program, self.kernel, t, block), guess):
                self.kernel.settle(block, found.point.tolist())
                flag = call()
                if not flag or self._failed() not in (block, -1):
                    self._solved(t, block, found.way, guess)
                    return flag
        self.kernel.settle(block, guess.tolist())
        if self._is_met(t, block, guess):
            self.kernel.be_content()
            return call()
        self.tried.add(block)
        self._left -= 1
        return call()

    def _beside(self, t: float, block: int, guess: Vector, call: Callable[[], int]) -> bool:
        """Whether the kernel itself finds a root from beside the guess, or apart from it: that is
        a hundred times as quick. Of several the nearest is taken."""
        from planarc.solve.rescue.ladder import FAR, distance, moved

        found: list[tuple[float, str, list[float]]] = []
        for way, points in moved(guess):
            for point in map(list, points):
                self.kernel.settle(block, point)
                if call() == 0:
                    found.append((distance(self._tears(block), guess), way, point))
            if any(way_off <= FAR for way_off, _, _ in found):
                break
        for _, way, point in sorted(found)[:1]:
            self.kernel.settle(block, point)
            if call() == 0:
                self._solved(t, block, way, guess)
                return True
        return False

    def _is_met(self, t: float, block: int, guess: Vector) -> bool:
        """Whether the guess itself is a root, at which slopes are singular."""
        found = BlockFunction(self.program, self.kernel, t, block)(guess)
        return found is not None and not found.any()

    def _tears(self, block: int) -> Vector:
        import numpy as np

        slots = [self.program.slots[repr(x)] for x in self.program.blocks[block].tears]
        return np.array([self.kernel.w[s] for s in slots])

    def _solved(self, t: float, block: int, way: str, guess: Vector) -> None:
        from planarc.solve.rescue.ladder import distance

        self.moved = distance(self._tears(block), guess)
        self.tried.discard(block)
        self.notes.setdefault((block, self.begun), self._note(t, block, way))

    def forget(self) -> None:
        """Tell nothing of solutions that were found on the way: they led nowhere."""
        self.notes = {key: note for key, note in self.notes.items() if not key[1]}

    def _note(self, t: float, block: int, way: str) -> Diagnostic:
        infos = [self.program.equations[e] for e in self.program.blocks[block].equations]
        self.leapt = (infos[0].text,)
        origin, hint = "the start values", "write start values nearer to the solution that you mean"
        if self.begun:
            origin = "the values before"
            hint = (
                "where equations have several solutions, give their variables dynamics of their own"
            )
        return Diagnostic(
            "R436",
            f"`{infos[0].text}` has no solution by Newton's steps from {origin} at "
            f"t = {t:.6g} s: {way} found one",
            infos[0].span,
            severity=Severity.NOTE,
            hint=hint,
        )

    def account(self, t: float, block: int) -> Account | None:
        """What was tried for a block that stays unsolved; None where nothing was."""
        if block not in self.tried:
            return None
        from planarc.solve.messages.replay import Replay
        from planarc.solve.rescue.ladder import WAYS

        program, origin = self.program, self.kernel.origin(block)
        code = program.blocks[block]
        replay = Replay(program, self.kernel, t)
        replay.residuals(block)
        off = replay.residuals_at(block, origin)
        infos = [program.equations[e] for e in code.equations]
        worst = sorted(zip(off, infos, strict=True), key=lambda pair: -abs(pair[0]))[:3]
        names = [text(tear) for tear in code.tears]
        return Account(tuple(zip(names, origin, strict=True)), tuple(worst), tuple(WAYS))

    def told(self, found: Diagnostic, t: float, block: int) -> Diagnostic:
        """The message about a block without solution, with what was tried for it."""
        from planarc.solve.messages.trouble import Unsolved

        account = self.account(t, block)
        if account is None or not isinstance(found, Unsolved) or self.program.mechanism is not None:
            return found
        hint = f"{found.hint}; {account}" if found.hint else str(account)
        return replace(found, hint=hint)


class Account(Data):
    """The search for a solution: where it began, how far equations are off there, and its ways."""

    origin: tuple[tuple[str, float], ...]
    worst: tuple[tuple[float, EquationInfo], ...]
    ways: tuple[str, ...]

    def __str__(self) -> str:
        """A clause for a hint."""
        from planarc.solve.messages.trouble import values

        return f"from {values(self.origin)} none was found by {listed(self.ways, 'or')}"


class BlockFunction:
    """The residuals of a block of the top by its tears; what is computed before it is as the
    workspace has it."""

    def __init__(self, program: Program, kernel: Kernel, t: float, block: int) -> None:
        from planarc.solve.messages.replay import Replay

        self._replay, self._block = Replay(program, kernel, t), block
        self._replay.residuals(block)

    def __call__(self, x: Vector) -> Vector | None:
        import numpy as np

        found = self._replay.residuals_at(self._block, x.tolist())
        return np.array(found) if all(map(math.isfinite, found)) else None

    def slopes(self, x: Vector) -> Vector | None:
        import numpy as np

        self._replay.residuals_at(self._block, x.tolist())
        found = np.array(self._replay.slopes(self._block))
        return found if np.isfinite(found).all() else None


def _block_of(program: Program, equation: int) -> int:
    """The block in which an equation is used, or -1."""
    for i, code in enumerate(program.blocks):
        used = {let.equation for let in code.body if isinstance(let, Let)}
        if equation >= 0 and (equation in used or equation in code.equations):
            return i
    return -1
