"""Formulas of comments as print has them."""

from __future__ import annotations

import pytest

from planarc.catalog.handbook.formula import formula


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("phib = phia + phi", "<i>φ</i><sub>b</sub> = <i>φ</i><sub>a</sub> + <i>φ</i>"),
        ("f = c*(s - s_unstretched)", "f = c·(s − <i>s</i><sub>unstretched</sub>)"),
        ("v^2, r^(-1)", "v<sup>2</sup>, r<sup>−1</sup>"),
        ("axis.tau = -tb", "axis.<i>τ</i> = −<i>t</i><sub>b</sub>"),
        ("turns frame_b counter-clockwise", "turns frame_b counter-clockwise"),
        ("`a_b*2` & <x>", "<code>a_b*2</code> &amp; &lt;x&gt;"),
        ("phase is a mutual word", "phase is a mutual word"),
        ("tauMax, phi_rel0", "<i>τ</i><sub>Max</sub>, <i>φ</i><sub>rel0</sub>"),
    ],
)
def test_formulas(text: str, printed: str) -> None:
    assert formula(text) == printed
