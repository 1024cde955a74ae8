"""The options of a run, as data."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

from msgspec import field

from planarc.core.data import Data

#: More rows than this are a mistake in the options rather than a wish.
MOST_ROWS = 20_000_000


class Backend(StrEnum):
    NATIVE = "native"
    NUMPY = "numpy"


def fastest_backend() -> Backend:
    """The fastest one that is installed."""
    from importlib.util import find_spec

    return Backend.NATIVE if find_spec("llvmlite") is not None else Backend.NUMPY


class Solver(StrEnum):
    """An integrator by its name; `home` is the module of `solve/solvers` that makes it, or none
    where the whole run is that of an exported model; `fixed` whether its steps have one length,
    which the user gives."""

    home: str
    fixed: bool

    def __new__(cls, name: str, home: str, fixed: bool = False) -> Solver:
        member = str.__new__(cls, name)
        member._value_, member.home, member.fixed = name, home, fixed
        return member

    AUTO = "auto", "cvode"
    CVODE_BDF = "cvode-bdf", "cvode"
    CVODE_ADAMS = "cvode-adams", "cvode"
    LSODA = "lsoda", "scipy"
    SCIPY_BDF = "scipy-bdf", "scipy"
    EULER = "euler", "fixed", True
    RK4 = "rk4", "fixed", True
    EXPORTED = "exported", ""  # explicit steps, as FMUs and pages take
    EXPORTED_STIFF = "exported-stiff", ""  # implicit ones


#: Those that take steps of one length.
FIXED_STEP = tuple(solver for solver in Solver if solver.fixed)


class Units(StrEnum):
    """The treatment of units that differ in an equation, a binding or a connection."""

    WARN = "warn"
    ERROR = "error"
    OFF = "off"


class Redundant(StrEnum):
    """The treatment of joints that hold a motion which others hold already."""

    REFUSE = "refuse"
    ACCEPT = "accept"  # the forces that they leave open are those of least squares


#: How redundant joints are accepted, in a hint.
ACCEPTING = '`--redundant accept` (in Python `redundant="accept"`)'


class Contacts(StrEnum):
    """The treatment of rigid contacts."""

    EVENTS = "events"
    STEPPING = "stepping"  # steps of one length, with the impulses of all contacts at once


class RunOptions(Data):
    """Times in seconds. None takes what the model's `experiment` annotation says.

    `values` sets parameters (`rod.L`), `starts` start values (`x` of `x.start`). Without a choice
    of `contact`, crowds are stepped. `near` are values of all candidates for states where a run
    like this one began: better guesses than start values that nothing holds.
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
    contact: Contacts | None = None
    values: Mapping[str, float] = field(default_factory=dict)
    starts: Mapping[str, float] = field(default_factory=dict)
    near: tuple[float, ...] | None = None
