"""Amplitudes and phases of the frequencies in a row of samples.

Of n samples of a signal, frequency k (0 to n/2) is k periods in the whole row. The
amplitude is that of a sine with this frequency; the phase is that of a cosine, in radians.
"""

from __future__ import annotations

from collections.abc import Sequence


def real_spectrum(arguments: Sequence[float]) -> list[float]:
    """The samples and their number n in; a flag (0 fine, 1 when n is odd), n/2 + 1
    amplitudes and as many phases out."""
    import numpy as np

    count = int(arguments[-1])
    samples = np.asarray(arguments[:count], dtype=float)
    lines = count // 2 + 1
    if count == 0 or count % 2:
        return [1.0] + [0.0] * (2 * lines)
    spectrum = np.fft.rfft(samples)
    return [0.0, *(np.abs(spectrum) * 2 / count).tolist(), *np.angle(spectrum).tolist()]
