"""The arguments of `impact(...)`, by which a touch of two rigid surfaces speaks to the solver.

    gap, v, a           distance, its first and second derivative
    slip, a_slip        velocity of the first surface along the second, its derivative
    f_n, f_t            normal force, and friction along slip
    e, mu               coefficients of restitution and friction

and, given back by the operator at every event in which some touch changes:

    held                the surfaces rest on each other: the model has a = 0, else f_n = push_n
    way                 0 sticks: a_slip = 0; 1, -1 slides: f_t = -way*mu*f_n; 2: f_t = push_t
    rest                since when they rest
    impulse             normal impulse of the last impact, 0 where there was none
    low                 the gap at which they meet next
    push_n, push_t      0 but for moments in which the operator learns what a force does
"""

from __future__ import annotations

from planarc.ir.flat import Base

KEPT = ("held", "way", "rest", "impulse", "low", "push_n", "push_t")
NAMES = ("gap", "v", "a", "slip", "a_slip", "f_n", "f_t", "e", "mu", *KEPT)
#: The types of arguments that are not Real alone.
BASES = {
    "held": (Base.BOOLEAN,),
    "way": (Base.INTEGER,),
    **dict.fromkeys(("e", "mu"), (Base.REAL, Base.INTEGER)),
}
