"""Many runs of one model at once, on arrays: for studies without a native back end.

In:   Program, the text for arrays (`codegen.numpy.printer.source(arrays=True)`), a kernel
      for each run, requests that differ in parameters and start values only
Out:  a Result for each run, or None where it has to be run by itself

NumPy takes as long for an operation on a hundred numbers as on one, so the cost of the
text is shared by all runs. Each has its own time, step and states, so that its result
does not depend on which others are with it. Each is started by itself, as ever.

Runs fall out, to be run by themselves, that cannot start, that fail an assertion, that
are stiff, or that pass a place where the batch finds no way. Models with events, or with
functions that cannot be put in place, are not for batches: see `may_batch`.
"""

from __future__ import annotations

from planarc.solve.batch.simulate import may_batch, simulate_batch

__all__ = ["may_batch", "simulate_batch"]
