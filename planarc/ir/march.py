"""What CVODE's march in machine code is given, and what it tells (`codegen.native.march`)."""

from __future__ import annotations

import ctypes
from ctypes import c_double, c_int64, c_void_p
from typing import Any, Final

#: A flag of CVODE: the step was made, and there is something to warn of.
WARNING: Final = 99


#: A zero function may dip through zero within a step where a parabola comes nearer to zero than
#: this part of its way in two steps, and that way is more than this part of its largest size.
DIP_MARGIN: Final = 0.25
DIP_NOISE: Final = 1e-6
#: Points since the march went on from which there is a parabola, and those that are kept: the next
#: one is compared with it.
DIP_POINTS: Final = 3
POINTS: Final = 4
#: A zero function that is off its parabola, or at first a straight line, by more than its distance
#: from zero over this is looked at all along the step.
ROUGH_MARGIN: Final = 10.0
ROUGH_NOISE: Final = 1e-4  # parts of its largest size by which it is off, whatever comes
#: A step whose ends have derivatives of different signs may have gone across a pole where it is
#: off the trapezoidal rule by more than this part of the larger one times the step.
MISFIT: Final = 0.1
#: Growth of a derivative on the way of a step from which it has a pole there.
GROWTH: Final = 1e3
#: What an angle of a loop moves by in a step at most, in rad. A loop can be closed in several ways:
#: where its angles move farther than to the next one, Newton's method may take that. Where others,
#: of which sines are asked, move farther, zero functions may do anything within the step.
REACH: Final = 0.5


class Arguments(ctypes.Structure):
    """The march of one run; pointers are those of arrays and of SUNDIALS' objects. `next`,
    `count`, `taken`, `failed`, `bound`, `looks`, `poles`, `seen`, `turned`, `farthest` and `dips`
    are written on the way."""

    _fields_ = (
        ("memory", c_void_p),  # of CVODE
        ("y", c_void_p),  # N_Vector
        ("y_numbers", c_void_p),
        ("dense", c_void_p),  # N_Vector for interpolated states and scratch
        ("dense_numbers", c_void_p),
        ("context", c_void_p),
        ("workspace", c_void_p),
        ("slots", c_void_p),  # int64
        ("grid", c_void_p),
        ("rows", c_void_p),
        ("times", c_void_p),
        ("cvode", c_void_p),  # the functions CVode and CVodeGetDky
        ("interpolate", c_void_p),
        ("time", c_void_p),  # where CVODE writes the time reached
        ("limit", c_double),
        ("near", c_double),  # rows nearer than this to a root or the limit are left to Python
        ("columns", c_int64),
        ("grid_end", c_int64),
        ("next", c_int64),
        ("count", c_int64),
        ("steps", c_int64),
        ("taken", c_int64),
        ("failed", c_int64),
        ("blocks", c_void_p),  # that are looked at
        ("block_count", c_int64),
        ("scales", c_void_p),
        ("bound", c_double),
        ("least", c_double),  # the least bound that there may be
        ("looks", c_int64),
        ("kept_slots", c_void_p),  # int64, of the refuge
        ("kept_count", c_int64),
        ("guess", c_void_p),
        ("state", c_void_p),
        ("states", c_int64),
        ("kept_rows", c_void_p),
        ("places", c_void_p),  # int64, of the states and of their derivatives
        ("trail", c_void_p),  # of `Poles`
        ("poles", c_int64),
        ("relations", c_int64),
        ("points", c_void_p),  # `solve.solvers.dips`
        ("seen", c_int64),
        ("turning", c_void_p),  # int64, the slots of what sines are asked of
        ("factors", c_void_p),  # how far angles turn as what stands there moves by 1
        ("turning_count", c_int64),
        ("turned", c_void_p),  # where they were at the point before
        ("farthest", c_double),  # how far one has turned since then
        ("dips", c_int64),  # what a zero function may have done (`solve.solvers.dips.Suspicion`)
        ("flag", c_int64),  # CVODE's of a step that was made already, or -1
    )


#: Place (in numbers of 8 bytes) and type of each argument.
FIELDS: Final[dict[str, tuple[int, Any]]] = {
    name: (place, kind) for place, (name, kind) in enumerate(Arguments._fields_)
}
