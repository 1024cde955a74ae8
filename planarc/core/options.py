"""What a user may ask of a run, as data."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

from msgspec import field

from planarc.core.data import Data


class Backend(StrEnum):
    NATIVE = "native"
    NUMPY = "numpy"


def fastest_backend() -> Backend:
    """The fastest one that is installed."""
    from importlib.util import find_spec

    return Backend.NATIVE if find_spec("llvmlite") is not None else Backend.NUMPY


class Solver(StrEnum):
    AUTO = "auto"
    CVODE_BDF = "cvode-bdf"
    CVODE_ADAMS = "cvode-adams"
    LSODA = "lsoda"
    SCIPY_BDF = "scipy-bdf"
    IDA = "ida"
    EULER = "euler"
    RK4 = "rk4"


#: Those that take steps of one length.
FIXED_STEP = (Solver.EULER, Solver.RK4)


class Units(StrEnum):
    """What becomes of units that differ in an equation, a binding or a connection."""

    WARN = "warn"
    ERROR = "error"
    OFF = "off"


class Redundant(StrEnum):
    """What becomes of joints that hold a motion which others hold already."""

    REFUSE = "refuse"
    ACCEPT = "accept"  # the forces that they leave open are those of least squares


#: How redundant joints are accepted, in a hint.
ACCEPTING = '`--redundant accept` (in Python `redundant="accept"`)'


class RunOptions(Data):
    """Times in seconds. None takes what the model's `experiment` annotation says.

    `values` sets parameters (`rod.L`), `starts` start values (`x` of `x.start`).
    """

    start: float | None = None
    stop: float | None = None
    interval: float | None = None
    intervals: int | None = None
    tolerance: float | None = None
    solver: Solver = Solver.AUTO
    fixed_step: float | None = None  # seconds; `auto` is then `rk4`
    backend: Backend = Backend.NATIVE
    redundant: Redundant | None = None  # None: as the model was compiled
    values: Mapping[str, float] = field(default_factory=dict)
    starts: Mapping[str, float] = field(default_factory=dict)
