"""The kernel: a loaded program as the solver calls it, and what it can.

Every kernel evaluates: states in, derivatives, residuals and zero functions out. What only
some can is declared as a value: a solver asks `kernel.capabilities` and finds a protocol of
its own, or None.

    formulas   derivatives by the expressions          kernels of generated code
    start      residuals and differences in one call   native kernels
    machine    addresses for an integrator in C        native kernels
    reactions  the iteration of events                 native kernels of models that switch
    steps      steps with many contacts                native kernels of models with crowds
    lead       a way to the start                      models with simplified equations
    corners    instants to stop at                     kernels that tables drive

Example: an integrator with a Jacobian of its own takes the kernel's where it is offered.

    formulas = kernel.capabilities.formulas
    jacobian = None if formulas is None else formulas.state_jacobian(t, y)
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, MutableSequence, Sequence
from contextlib import contextmanager
from operator import itemgetter
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias

from planarc.core.data import Data
from planarc.ir.program import Program
from planarc.runtime.history import History

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from planarc.core.arrays import Vector


class Formulas(Protocol):
    """Derivatives from the expressions, by the implicit function theorem through blocks.

    What is given back is a matrix, a row for each value, or None where there is none: a
    function without derivative, a singular point.
    """

    def state_jacobian(self, t: float, y: Sequence[float]) -> Any:
        """d(derivatives of the states)/d(states)."""

    def derivatives(
        self, t: float, y: Sequence[float], leaves: Sequence[int], rows: Sequence[int]
    ) -> Any:
        """d(values in the slots `rows`)/d(states, then parameters or inputs in the slots
        `leaves`). The workspace is filled."""


class StartForm(Protocol):
    """Residuals and their differences in one call, for the conditions at the start."""

    def differences(
        self, t: float, u: Vector, columns: tuple[int, ...], slots: tuple[int, ...], below: bool
    ) -> Vector | None:
        """Row 0: the residuals of the blocks below the top, with all candidates as `u`, then
        those of the initial equations, then the values of some slots; below it their
        derivatives by the candidates `columns`, a row for each, by differences. `below`: the
        blocks' residuals alone, whatever the top. None where a number is not finite."""

    def root(
        self,
        t: float,
        u: Vector,
        columns: tuple[int, ...],
        slots: tuple[int, ...],
        rows: Sequence[int],
        wanted: Vector,
    ) -> Vector | None:
        """All candidates, of which `columns` are moved until of row 0 of `differences` the numbers
        at `rows`, as many, are those of `wanted`. None where Newton's method needs help."""

    def motions(self, t: float, u: Vector, slots: tuple[int, ...], part: float) -> Vector | None:
        """An orthonormal basis, in columns, of what changes none of row 0 of `differences`, to
        first order; rows below this part of the longest depend on others. None where singular
        values must tell."""

    def begin(
        self, t: float, plan: NDArray[np.int64], slots: tuple[int, ...]
    ) -> Sequence[list[Any]] | None:
        """The start where it is plain (`planarc.ir.begin`), `slots` being those of fixed variables:
        what stands first in the room. The workspace is at the start. None where it is not plain."""


class Addresses(Data):
    """Compiled functions of a native kernel as machine addresses, for an integrator in C.

    cv_rhs     int (double t, N_Vector y, N_Vector ydot, void *context)   as CVRhsFn
    cv_roots   int (double t, N_Vector y, double *g, void *context)       as CVRootFn
    march      int (Arguments *)                                          see `planarc.ir.march`
    context    what the functions above take
    workspace  the first number of `Kernel.w`
    records    of each block, by which a march knows it

    All live as long as the kernel that gave them.
    """

    cv_rhs: int
    cv_roots: int
    march: int
    records: tuple[int, ...]
    context: int
    workspace: int


#: `planarc.codegen.native.sweeps`, on arrays: starts, columns and entries of the rows, rest, mu,
#: inverse, x; the most sweeps, the tolerance.
Sweep: TypeAlias = "Callable[..., int]"


class Machine(Protocol):
    """Machine code that an integrator in C calls without a way back through Python."""

    def renew(self) -> None:
        """Be as a kernel that was just loaded, at the same addresses."""

    def addresses(self, vector_numbers: int) -> Addresses:
        """The addresses for machine code. `vector_numbers` is the address of SUNDIALS' function
        that gives a vector's numbers."""

    def sweep(self, *given: Any) -> int:
        """See `Sweep`."""

    def shift(self, shifts: Sequence[float]) -> None:
        """Move what `cv_roots` gives by so much; by nothing where none are given."""

    def measure(self, nominal: Sequence[float]) -> None:
        """Tell the sizes of the states, where differences find them smaller."""

    def cv_differences(self, matrix_numbers: int) -> int:
        """The address of the Jacobian by differences, as CVODE calls it. `matrix_numbers` is that
        of SUNDIALS' function that gives a matrix's numbers."""

    def cv_jacobian(self, matrix_numbers: int) -> int:
        """That by formulas, for the present choice of states, or 0 where there are none; where
        they fail, it takes those differences."""


class TouchMemory(Data):
    """What is known of the touches of a run: `touches` are the greatest speeds of their impacts,
    their accelerations after the last ones, and forces that show what forces do; `sizes` the
    greatest speed, acceleration, and acceleration by 1 N that were seen; `begins`: nothing was."""

    touches: Vector
    sizes: Sequence[float]
    begins: bool
    sharpness: float


class Reacted(Data):
    """An event that was iterated: states, zero functions and their greatest sizes; the states that
    were set anew, relations of which neither truth agreed; of each strike what was held, ways and
    impulses, each before and after it; what is known of touches now."""

    y: list[float]
    now: list[float]
    largest: list[float]
    reset: list[int]
    doubtful: list[int]
    struck: list[Vector]
    known: TouchMemory | None


class Reactions(Protocol):
    """The iteration of events in machine code."""

    def prepare(self, span: float, tolerance: float) -> None:
        """A run of this length begins, whose touches meet as exactly as that."""

    def react(
        self,
        y: Sequence[float],
        crossing: Mapping[int, bool],
        fired: Sequence[int],
        largest: Sequence[float],
        leaping: Collection[int],
        ahead: bool,
        known: TouchMemory | None,
    ) -> Reacted | None:
        """The iteration at the time of the workspace, from the states on, as
        `solve.events.iteration` does it: the relations of `crossing` get the other truth, samplers
        are `fired`; zero functions that are `leaping` across poles say nothing of sizes. None
        where that must be done there: the workspace is no use then."""


#: Keys of contacts, which rise, and the impulses of each along its normal and its slip.
Pressed: TypeAlias = "tuple[NDArray[np.int64], Vector]"


class Stepped(Data):
    """A step with contacts: the states at its end and in its middle, and which of them contacts
    changed."""

    end: Vector
    middle: Vector
    struck: NDArray[np.bool_]


class Steps(Protocol):
    """Steps of one length with contacts in machine code, as `solve.stepping` makes them."""

    #: What pressed in the step before.
    pressed: Pressed

    def are_apart(self, y: Sequence[float]) -> bool:
        """Whether it is sure that nothing overlaps at the time of the workspace."""

    def step(self, t: float, h: float, y: Sequence[float], depth: float) -> Stepped | None:
        """The step from `t` on; None where it is to be made in Python: something fails, or a
        contact is deeper than it moves in the step, by more than `depth`."""


class Reacting(Data):
    """What machine code does for a run in Python besides evaluating."""

    reactions: Reactions | None = None
    steps: Steps | None = None


#: From a program, the frame of a kernel, and the function of the memory and `ahead`.
ReactorMaker: TypeAlias = "Callable[[Program, Any, Callable[..., int]], Reacting]"

#: The program that leads to a start from simplified equations (`dae.HOMOTOPY`), loaded.
Lead: TypeAlias = "Callable[[], tuple[Program, Kernel]]"


class Capabilities(Data):
    """The abilities of a kernel besides evaluating; None where it lacks one."""

    formulas: Formulas | None = None
    start: StartForm | None = None
    machine: Machine | None = None
    reacting: Callable[[], Reacting] = Reacting
    lead: Lead | None = None
    corners: Sequence[float] = ()  # ascending


class Kernel(Protocol):
    """A loaded program with its own workspace: one a run, so that threads are safe.

    Calls return 0, or a positive number when a block could not be solved here (a smaller
    step may help), or a negative one when no step helps (a number is not finite, a
    domain error). `failed_block` then tells the block, or -1.

    `selection[i]` is the candidate that state i is. Nonlinear blocks start from the last
    accepted point, extrapolated with its velocities, never from the last call.
    """

    w: MutableSequence[float]
    history: History  # of the delayed signals: the run writes it

    @property
    def selection(self) -> Sequence[int]:
        """The candidates that are states, as `select` was told."""

    @property
    def capabilities(self) -> Capabilities:
        """The further abilities of this kernel."""

    @property
    def failed_block(self) -> int:
        """The failed block after a positive return, or -1."""

    @property
    def failed_equation(self) -> int:
        """The index in Program.equations after a negative return, or -1."""

    @property
    def near_singular(self) -> bool:
        """Whether a loop may have come near to a pose in which it can go on in several ways."""

    @property
    def open_block(self) -> int:
        """The last modal block whose equations left unknowns open in the last call, or -1."""

    def sway(self, block: int, amount: float) -> None:
        """Add to the accepted values of a block's tears: what it leaves open, moves."""

    def origin(self, block: int) -> list[float]:
        """The values that a block's tears start from: accepted ones, or their start values."""

    def settle(self, block: int, values: Sequence[float]) -> None:
        """Let a block of the top start from other values, until the next accepted point."""

    def be_content(self) -> None:
        """Until `parameters` runs, let a block of the top keep values that leave nothing of its
        residuals, though its slopes are singular there."""

    def parameters(self) -> int:
        """Run the list `parameters`."""

    def select(self, selection: Sequence[int]) -> None:
        """Choose the states; as many as `Program.state_count`, per block its `free` ones."""

    def accept(self, t: float) -> None:
        """Take the workspace's present values as the last accepted point."""

    def rhs(self, t: float, y: Sequence[float], ydot: MutableSequence[float]) -> int:
        """States in, their derivatives out; runs `levels`."""

    def outputs(self, t: float, y: Sequence[float]) -> int:
        """Fill every slot: `levels`, then `rest`."""

    def residuals(self, t: float, u: Sequence[float], r: MutableSequence[float]) -> int:
        """Evaluate with all candidates given as `u` (none solved for): the residuals of all blocks
        below the top, then of the initial equations. Fills every slot on the way."""

    def jacobian(self, block: int) -> Sequence[Sequence[float]]:
        """d(residuals)/d(tears) of a block at the workspace's present values."""

    def roots(self, t: float, y: Sequence[float], g: MutableSequence[float]) -> int:
        """The zero functions of all relations; event slots keep their stored values."""

    def discrete(self) -> int:
        """One pass of the discrete equations at the present values; a negative return is
        a failure. Whens and relations are the solver's business (`events`)."""


#: Takes the values of some slots out of a workspace.
Taker: TypeAlias = Callable[[Sequence[float]], tuple[float, ...]]
#: Gives slots of a workspace the values of others.
Copier: TypeAlias = Callable[[MutableSequence[float]], None]


#: Slots up to which they are taken one by one from an array, too: for more that takes several times
#: as long, and its numbers are slow to reckon with.
FEW = 6


def taker(slots: Sequence[int]) -> Taker:
    """What takes the values of these slots, in their order."""
    if len(slots) < 2:
        return lambda w: tuple(w[slot] for slot in slots)
    pick, places = itemgetter(*slots), list["NDArray[np.intp]"]()
    if len(slots) <= FEW:
        return pick

    def take(w: Any) -> tuple[float, ...]:
        if isinstance(w, list):
            found: tuple[float, ...] = pick(w)
            return found
        if not places:
            import numpy as np

            places.append(np.array(slots, np.intp))
        return tuple(w.take(places[0]).tolist())

    return take


def copier(targets: Sequence[int], sources: Sequence[int]) -> Copier:
    """What gives slots the values of others; no slot is both."""
    pairs, places = tuple(zip(targets, sources, strict=True)), list["NDArray[np.intp]"]()

    def copy(w: Any) -> None:
        if isinstance(w, list) or len(pairs) <= FEW:
            for target, source in pairs:
                w[target] = w[source]
            return
        if not places:
            import numpy as np

            places.extend(np.array(pairs, np.intp).T)
        w[places[0]] = w[places[1]]

    return copy


@contextmanager
def changed(kernel: Kernel, values: Mapping[int, float]) -> Iterator[None]:
    """A kernel with other values of parameters, by their slots; afterwards it has those of before.
    Variables are not computed again."""

    def give(new: Mapping[int, float]) -> None:
        for slot, value in new.items():
            kernel.w[slot] = value
        kernel.parameters()

    before = {slot: float(kernel.w[slot]) for slot in values}
    give(values)
    try:
        yield
    finally:
        give(before)
