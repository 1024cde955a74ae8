"""Newton's method for a block of two unknowns, the most frequent size: a single loop.

The rule is that of `numpy_block`, number for number, with its lists and loops written out:
a four-bar runs a third faster. Whatever is rare is left to the general form.
"""

from __future__ import annotations

from collections.abc import Sequence

from planarc.ir.newton import NEARLY, QUADRATIC
from planarc.solve.kernels.numpy.block import Block
from planarc.solve.kernels.numpy.support import Rows, solve_pair


class PairBlock(Block):
    """A block of two residuals."""

    def solve(self, residuals: Sequence[float], matrix: Rows) -> Sequence[float]:
        if self.evaluating:
            return super().solve(residuals, matrix)
        self.matrix = matrix
        self.done = True
        first, second = matrix
        p, q = residuals
        if not self._below:
            found = solve_pair(first[0], first[1], second[0], second[1], p, q)
            if found is None:
                return super().solve(residuals, matrix)
            return (-found[0], -found[1])
        x = [*self._values(self._w)]
        i, j = self._solved
        for k in self._free:
            value = x[k]
            p += first[k] * value
            q += second[k] * value
        a, b, c, d = first[i], first[j], second[i], second[j]
        s, t = max(abs(a), abs(b)), max(abs(c), abs(d))
        apart = abs(a * d - b * c) > NEARLY * s * t and s > NEARLY * t and t > NEARLY * s
        self.near = self.near or not apart
        found = solve_pair(a, b, c, d, p, q)
        if found is None:
            return super().solve(residuals, matrix)
        x[i], x[j] = -found[0], -found[1]
        return x

    def step(self, residuals: Sequence[float], matrix: Rows) -> Sequence[float]:
        if self.evaluating:
            return super().step(residuals, matrix)
        first, second = matrix
        i, j = self._solved
        p, q = residuals
        a, b, c, d = first[i], first[j], second[i], second[j]
        found = solve_pair(a, b, c, d, p, q)
        if self._count:
            s, t = self._sizes
            r, size = abs(p) / s, abs(q) / t
            size = r if r > size else size
            if found is None or not (size < self._size_of_residuals or size == 0.0):
                return super().step(residuals, matrix)
        elif found is None:
            return super().step(residuals, matrix)
        self.residuals = residuals
        self.matrix = matrix
        x = self._x
        self._before = x.copy()
        self._change = found
        self._factor = 1.0
        self._count += 1
        e, f = found
        x[i] = u = x[i] - e
        x[j] = v = x[j] - f
        e, f, u, v = abs(e), abs(f), abs(u), abs(v)
        if u > 1.0:
            e /= u
        if v > 1.0:
            f /= v
        size = e if e > f else f
        if size < QUADRATIC and e == e:
            self._small = True
            known = (u > 1.0 or e <= QUADRATIC * u) and (v > 1.0 or f <= QUADRATIC * v)
            if known or self._count >= self._most or self._is_last():
                self._finish()
                return x
        elif self._small:
            self._small = False
        if not (e < 1e300 and f < 1e300) or self._count >= self._most:
            self._checked(None, residuals, matrix)
        a, b, c, d = abs(a), abs(b), abs(c), abs(d)
        s = a if a > b else b
        t = c if c > d else d
        self._sizes = (s, t)
        p, q = abs(p) / s, abs(q) / t
        self._size_of_residuals = p if p > q else q
        return x
