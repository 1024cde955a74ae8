"""The solution of a block: the rule that both back ends follow, number for number.

Unknowns x: of a block below the top those of its tears that are no states, of a
block in the top level all tears. They start

    below the top   at the last accepted point, moved along its derivatives:
                    x0 = x_a + h*x_a' + h^2/2*x_a'', h = t - t_a
                    without the last term where it is longer than `BENT`: where
                    accelerations are without bounds, a start beyond all measure would
                    pass the tests below, which are relative to it
    in the top      at their last accepted values

so that the result depends on time, states and the accepted point alone. A linear
block needs no start: its residuals at zero and its matrix give its unknowns at once.
Others take steps until one is so small that the next would be its square:

    small      relative to max(1, |x|) below `QUADRATIC`
    the last   small, and below that part also of each |x|, or else, in every equation, of
               the largest term |J_ik*x_k|: a current of 1e-8 A counts behind 1 GOhm

How two unknowns are solved for, and how sine and cosine of an angle follow from those of the step
before, is each back end's own: results differ by rounding.

A step that does not lessen the residuals is halved, `HALVINGS` times at most.
The solve fails (and a smaller step of the integrator may help) when the matrix is
singular, after too many steps, or when no part of a step lessens the residuals; but after
a small step this is rounding, and the solve ends there. In the top it also ends where the
matrix is singular and residuals are exactly zero, x = sin(x) from x = 0, when no other root
was found (`Kernel.be_content`). Below the top it also fails when
the result lies further than `FAR` from where it started.

A *modal* block of the top, whose matrix changes with truths at events, may be singular
in some modes and still have solutions: two brakes that hold one shaft share its load in
any way. Where its equations agree (`AGREES`), the unknowns that they leave open keep
their accepted values. That what moves does not depend on these is checked by the run.
"""

from __future__ import annotations

from typing import Final

QUADRATIC: Final = 1e-7
#: Size of a step that nothing can tell from none.
NOTHING: Final = 1e-30
HALVINGS: Final = 40
STEPS_BELOW: Final = 12
STEPS_TOP: Final = 60
FAR: Final = 0.5
#: Distance from the accepted value, relative to max(1, |x_a|).
BENT: Final = 10.0
#: Size of a pivot, relative to the largest entry of its row, that makes a matrix singular.
SINGULAR: Final = 1e-14
#: Size of a row of a loop's matrix beside another one, or of a determinant beside its rows, where
#: the loop is near to a pose in which it can go on in several ways: digits are lost there.
NEARLY: Final = 3e-3
#: Size of one that leaves its unknown open, where a modal block is singular.
DEPENDENT: Final = 1e-12
#: Rest of an equation, relative to its row times the largest unknown, below which the equations
#: of a singular block agree.
AGREES: Final = 1e-9
#: Residual, relative to the sum of its terms, below which a direct solution counts.
FITS: Final = 1e-11
#: Of conditions at the start: longest change of an unknown in one step, in its own measure
#: (radians, metres); the part of the residuals that a longer one may leave, since it was along a
#: straight line; residuals that count as zero, per size of their row of slopes and of one that
#: is smaller than the second; what a step must leave of them at least; and the step that leaves
#: nothing to be gained; and the parts of a step that are tried, each half the one before (of
#: residuals that are zero but for rounding the whole step alone).
LONGEST: Final = 0.5
STRAIGHT: Final = 1e-3
SMALL: Final = 1e-10
SMALLEST_ROW: Final = 1e-3
LESS: Final = 1 - 1e-4
ENOUGH: Final = 1e-9
MOST_HALVINGS: Final = 25
#: Factor by which what tells of a rank must be away from where it changes, to be trusted without
#: singular values.
CLEAR: Final = 1e2
#: Step of an unknown for a difference, relative to max(1, |x|).
DIFFERENCE: Final = 1.5e-8
#: Size of a column of a constraint Jacobian, beside the largest, that is rounding alone.
NEGLIGIBLE: Final = 1e-9
#: Largest sensitivity x of a determined candidate to a state that is accepted. Where velocities are
#: states, too, errors of a position enter those that it determines with x squared.
WORST: Final = 3.5
#: The same where velocities are given.
WORST_DRIVEN: Final = 5.0
#: Factor by which a worse choice that was accepted must grow to be looked at again.
GROWN: Final = 1.3
