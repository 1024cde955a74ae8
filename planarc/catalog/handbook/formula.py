"""Formulas of plain text as print has them: Greek letters, subscripts, powers.

In:   str   such as `rb = ra + R(phia)*r, f = c*(s - s_unstretched)^2`
Out:  str   HTML, in which everything else is escaped

    phi, tauMax         a Greek letter, what follows it below
    r_0, f_N, ra, fb    a letter, what follows it below
    x^2, 3*c            a power, a product

Words, names of several letters (`frame_b`, `drivenFlange`) and what stands in backticks stay.

Example: `phib = phia + phi` becomes φ<sub>b</sub> = φ<sub>a</sub> + φ
"""

from __future__ import annotations

import html
import re

_GREEK = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ε", "eta": "η",
    "theta": "θ", "kappa": "κ", "lambda": "λ", "mu": "μ", "rho": "ρ", "sigma": "σ", "tau": "τ",
    "phi": "φ", "psi": "ψ", "omega": "ω",
}  # fmt: skip
_BELOW = r"_\w+|[ab0-9]|[A-Z]\w*"
_NAME = re.compile(
    rf"(?P<greek>{'|'.join(_GREEK)})(?P<below>{_BELOW})?|(?P<letter>[A-Za-z])(?P<side>_\w+|[ab0-9])"
)
_PIECE = re.compile(
    r"`[^`]*`|(?<![\w.])[A-Za-z]\w*(?:\.[A-Za-z]\w*)*|\^\(?(?P<power>-?\d+)\)?|\*|->"
    r"|(?P<minus>(?<![A-Za-z])-)|.",
    re.DOTALL,
)


def formula(text: str) -> str:
    """The text as HTML."""
    return "".join(map(_piece, _PIECE.finditer(text)))


def _piece(found: re.Match[str]) -> str:
    piece = found[0]
    if found["power"]:
        return f"<sup>{found['power'].replace('-', '−')}</sup>"
    if found["minus"]:
        return "−"
    if piece[0] == "`":
        return f"<code>{html.escape(piece[1:-1])}</code>"
    if piece[0].isalpha():
        return ".".join(map(_name, piece.split(".")))
    return {"*": "·", "->": "→"}.get(piece) or html.escape(piece)


def _name(name: str) -> str:
    """A variable with what stands below it."""
    found = _NAME.fullmatch(name)
    if found is None:
        return html.escape(name)
    sign = _GREEK[found["greek"]] if found["greek"] else found["letter"]
    below = (found["below"] or found["side"] or "").strip("_").replace("_", " ")
    return f"<i>{sign}</i>" + (f"<sub>{below}</sub>" if below else "")
