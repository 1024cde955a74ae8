"""The SUNDIALS libraries that the scikit-sundae wheel brings, opened with ctypes.

They are found through the wheel's own list of files, so that nothing of the wheel
is imported (that costs 0.3 s, and its LAPACK parts bring OpenBLAS in). Of
SUNDIALS only the parts needed are opened: the core and CVODE, which holds the
serial vector and the dense matrix and solver as well.

Sizes of vectors are passed in registers and never read from structures, so it
does not matter whether the wheel was built with 32 or 64 bit indices; vector data
is reached by `N_VGetArrayPointer`. The major version is checked.
"""

from __future__ import annotations

import ctypes as C
import re
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

MAJOR_VERSIONS = (7,)
_PARTS = ("core", "cvode")
_DISTRIBUTION = "scikit-sundae"
_LIBRARY = re.compile(r"(?:^|/)(?:lib)?sundials_([a-z]+)[-_.][^/]*\.(?:so|dll|dylib)\b[^/]*$")

_P, _I, _D, _L = C.c_void_p, C.c_int, C.c_double, C.c_int64
_LONGS = C.POINTER(C.c_long)

#: Name: result, arguments. C's `long int` differs between systems: ctypes knows it.
_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "SUNDIALSGetVersionNumber": (_I, (C.POINTER(_I),) * 3 + (C.c_char_p, _I)),
    "SUNContext_Create": (_I, (_I, C.POINTER(_P))),
    "SUNContext_Free": (_I, (C.POINTER(_P),)),
    "SUNContext_ClearErrHandlers": (_I, (_P,)),
    "N_VNew_Serial": (_P, (_L, _P)),
    "N_VEnableFusedOps_Serial": (_I, (_P, _I)),
    "N_VGetArrayPointer": (_P, (_P,)),
    "N_VDestroy": (None, (_P,)),
    "SUNDenseMatrix": (_P, (_L, _L, _P)),
    "SUNDenseMatrix_Data": (_P, (_P,)),
    "SUNMatDestroy": (None, (_P,)),
    "SUNLinSol_Dense": (_P, (_P, _P, _P)),
    "SUNLinSol_SPGMR": (_P, (_P, _I, _I, _P)),
    "SUNLinSolFree": (_I, (_P,)),
    "CVodeCreate": (_P, (_I, _P)),
    "CVodeFree": (None, (C.POINTER(_P),)),
    "CVodeInit": (_I, (_P, _P, _D, _P)),
    "CVodeReInit": (_I, (_P, _D, _P)),
    "CVodeSVtolerances": (_I, (_P, _D, _P)),
    "CVodeSetUserData": (_I, (_P, _P)),
    "CVodeSetLinearSolver": (_I, (_P, _P, _P)),
    "CVodeSetJacFn": (_I, (_P, _P)),
    "CVodeSetInitStep": (_I, (_P, _D)),
    "CVodeSetJacEvalFrequency": (_I, (_P, C.c_long)),
    "CVodeSetMaxStep": (_I, (_P, _D)),
    "CVodeSetMinStep": (_I, (_P, _D)),
    "CVodeSetMaxNumSteps": (_I, (_P, C.c_long)),
    "CVodeSetMaxHnilWarns": (_I, (_P, _I)),
    "CVodeSetMaxErrTestFails": (_I, (_P, _I)),
    "CVodeSetMaxConvFails": (_I, (_P, _I)),
    "CVodeSetStopTime": (_I, (_P, _D)),
    "CVodeSetNoInactiveRootWarn": (_I, (_P,)),
    "CVodeRootInit": (_I, (_P, _I, _P)),
    "CVodeSetRootDirection": (_I, (_P, _P)),
    "CVodeGetRootInfo": (_I, (_P, _P)),
    "CVodeGetDky": (_I, (_P, _D, _I, _P)),
    "CVodeGetEstLocalErrors": (_I, (_P, _P)),
    "CVodeGetErrWeights": (_I, (_P, _P)),
    "CVodeGetLastStep": (_I, (_P, C.POINTER(_D))),
    "CVodeGetIntegratorStats": (_I, (_P,) * 11),
    "CVodeGetLinSolveStats": (_I, (_P,) * 9),
    "CVodeGetNumSteps": (_I, (_P, _LONGS)),
    "CVodeGetNumRhsEvals": (_I, (_P, _LONGS)),
    "CVodeGetNumLinRhsEvals": (_I, (_P, _LONGS)),
    "CVodeGetNumJacEvals": (_I, (_P, _LONGS)),
    "CVodeGetNumLinConvFails": (_I, (_P, _LONGS)),
    "CVode": (_I, (_P, _D, _P, C.POINTER(_D), _I)),
}


class Unavailable(Exception):
    """A solver cannot be used here; the text says why."""


class Sundials:
    """The opened libraries; functions are attributes under their C names."""

    def __init__(self, libraries: list[C.CDLL]) -> None:
        self.version = ""
        for name, (result, arguments) in _FUNCTIONS.items():
            function = _find(libraries, name)
            function.restype, function.argtypes = result, list(arguments)
            setattr(self, name, function)

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(name)

    def address(self, name: str) -> int:
        return C.cast(getattr(self, name), C.c_void_p).value or 0


def _find(libraries: list[C.CDLL], name: str) -> Any:
    for library in libraries:
        try:
            return getattr(library, name)
        except AttributeError:
            continue
    raise Unavailable(f"its SUNDIALS has no function {name}")


@cache
def open_sundials() -> Sundials:
    """The functions of CVODE and what it needs. Raises `Unavailable` with the reason."""
    sundials = Sundials(_opened()[::-1])
    numbers = [_I(), _I(), _I()]
    label = C.create_string_buffer(32)
    sundials.SUNDIALSGetVersionNumber(*(C.byref(n) for n in numbers), label, 32)
    sundials.version = ".".join(str(n.value) for n in numbers)
    if numbers[0].value not in MAJOR_VERSIONS:
        raise Unavailable(f"SUNDIALS {sundials.version} is a version that planarc does not know")
    return sundials


def _opened() -> list[C.CDLL]:
    try:
        return [C.CDLL(str(path)) for path in _library_files()]
    except OSError as problem:
        raise Unavailable(f"SUNDIALS cannot be opened: {problem}") from None


def _library_files() -> list[Path]:
    """The files of the parts needed, in the order of loading."""
    site, files = _wheel()
    found: dict[str, Path] = {}
    for name in files:
        match = _LIBRARY.search(name)
        if match:
            found.setdefault(match[1], site / name)
    missing = [part for part in _PARTS if part not in found]
    if missing:
        raise Unavailable(f"{_DISTRIBUTION} brings no SUNDIALS library `{missing[0]}`")
    return [found[part] for part in _PARTS]


def _wheel() -> tuple[Path, list[str]]:
    """The wheel's folder, and its list of files (PEP 376). `importlib.metadata`
    reads it too, but its own import takes longer than all that is done here."""
    spec = find_spec("sksundae")
    if spec is None or spec.origin is None:
        raise Unavailable(f"{_DISTRIBUTION} is not installed")
    site = Path(spec.origin).parent.parent
    lists = sorted(site.glob("scikit_sundae-*.dist-info/RECORD"))
    lines = lists[-1].read_text("utf-8").splitlines() if lists else []
    return site, [line.partition(",")[0].strip('"') for line in lines]
