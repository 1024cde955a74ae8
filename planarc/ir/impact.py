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

and those of `crowd(...)`, by which a body says that it meets all others of its component:

    x, y, phi           where its frame is
    v_x, v_y, w         its velocities
    a_x, a_y, z         its accelerations
    from_x, from_y      a round bar in the frame: where its middle line begins
    to_x, to_y          and where it ends; a circle where both are one point
    radius              half its thickness
    e, mu               coefficients of restitution and friction
    push_x .. push_phi  force and torque on it, given back: the model has f = -push

Bodies with the same pushes are one body and do not meet each other.
"""

from __future__ import annotations

from planarc.ir.flat import Base

KEPT = ("held", "way", "rest", "impulse", "low", "push_n", "push_t")
NAMES = ("gap", "v", "a", "slip", "a_slip", "f_n", "f_t", "e", "mu", *KEPT)
CROWD_KEPT = ("push_x", "push_y", "push_phi")
CROWD_NAMES = (
    *("x", "y", "phi", "v_x", "v_y", "w", "a_x", "a_y", "z"),
    *("from_x", "from_y", "to_x", "to_y", "radius", "e", "mu", *CROWD_KEPT),
)
#: The types of arguments that are not Real alone.
BASES = {
    "held": (Base.BOOLEAN,),
    "way": (Base.INTEGER,),
    **dict.fromkeys(
        ("e", "mu", "from_x", "from_y", "to_x", "to_y", "radius"), (Base.REAL, Base.INTEGER)
    ),
}
