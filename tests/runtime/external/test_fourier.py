"""Spectra in the place of external ones."""

from __future__ import annotations

import math

import numpy as np
import pytest

from planarc.runtime import external


def test_a_spectrum_tells_amplitudes_and_phases() -> None:
    n = 24
    t = np.arange(n) / n
    u = 3 * np.cos(2 * math.pi * 2 * t + 0.4) + 1.5 * np.sin(2 * math.pi * 5 * t)
    found = external.call_numbers("ModelicaFFT_kiss_fftr", (*u.tolist(), n))
    amplitudes, phases = found[1 : n // 2 + 2], found[n // 2 + 2 :]
    assert found[0] == 0
    wanted = [{2: 3.0, 5: 1.5}.get(k, 0.0) for k in range(n // 2 + 1)]
    assert amplitudes == pytest.approx(wanted, abs=1e-12)
    assert phases[2] == pytest.approx(0.4)
    assert phases[5] == pytest.approx(-math.pi / 2)


def test_an_odd_number_of_samples_is_flagged() -> None:
    assert external.call_numbers("ModelicaFFT_kiss_fftr", (1.0, 2.0, 3.0, 3))[0] == 1
