"""Python names for a model's symbols.

`crank.frame_b.r[1]` becomes `crank_frame_b_r_1`, `der(x)` `der_x`, `$t4` `t4`. A name
that Python or the generated text itself uses, or that another symbol has already,
gets a number. Nothing of a user's name but letters, digits and `_` comes through.
"""

from __future__ import annotations

import keyword
import re

from planarc.ir.expr import Expr, Op, text
from planarc.ir.loop import Loop
from planarc.runtime import elementary

#: Names that the generated text itself uses, beside the elementary functions'; see
#: `planarc.solve.kernels.numpy.support`.
_TAKEN = """
    t w block blocks tears range columns seeds column by_columns
    pow inf nan safe safe_div
    parameters levels rest initial roots discrete external past
    slopes tape
    POW DIV NOT AND OR sum prod
"""


class Names:
    """Gives every symbol, left limit, event and loop of a program its own Python name."""

    def __init__(self) -> None:
        self.loops: dict[Loop, str] = {}
        self._names: dict[Expr, str] = {}
        self._taken = {*_TAKEN.split(), *elementary.TABLE}

    def __call__(self, symbol: Expr) -> str:
        found = self._names.get(symbol)
        if found is None:
            found = self._names[symbol] = self._free(_plain(symbol))
        return found

    def of_loop(self, loop: Loop) -> str:
        if loop not in self.loops:
            self.loops[loop] = self._free("turns_of_" + re.sub(r"[^A-Za-z0-9]+", "_", loop.name))
        return self.loops[loop]

    def _free(self, name: str) -> str:
        candidate, number = name, 1
        while candidate in self._taken:
            number += 1
            candidate = f"{name}_{number}"
        self._taken.add(candidate)
        return candidate


def _plain(symbol: Expr) -> str:
    if symbol.op is Op.SYMBOL:
        name, order = symbol.data
        prefix = {0: "", 1: "der_"}.get(order, f"der{order}_")
    else:
        name, prefix = text(symbol), ""
    # ASCII only: Python would fold other letters, and two names could become one.
    plain = re.sub(r"[^A-Za-z0-9]+", "_", prefix + name).strip("_")
    if not plain or plain[0].isdigit():
        plain = f"v_{plain}"
    return plain + "_" if keyword.iskeyword(plain) or keyword.issoftkeyword(plain) else plain


def comment(name: str) -> str:
    """The user's name, fit for a comment: no line break, no control character."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in name)
