"""Alias elimination: variables that are another variable, its derivative, or constant.

In:   Dae           continuous variables and equations as `lower` made them
Out:  Elimination   the variables and equations that remain, and what the others are

    a = b    a = -b    0 = a + b        one variable, maybe with a sign
    v = der(x)                          v is the first derivative of x, so that
    a = der(v)                          a is the second one
    x = p*sin(q)    2*x = 3             constant while running (parameters only)

Equations may become such when others have been put in (0 = f1 + f2 and f2 = 0), so
equations wait in a queue and come back when one of their variables has vanished. Those
that name a derivative come last, so that the derivative of a constant is told as such.

Example: the hinge that turns a rod in the ground.

    base.phi = 0;  rod.phi = base.phi + rev.phi;  rev.w = der(rev.phi)
        base.phi -> 0,  rod.phi -> rev.phi,  rev.w -> der(rev.phi)

Of two names the one of higher StateSelect stays, then a public one, then the first.

Needs:     scalar equations; parameters and discrete variables are told by name.
Promises:  nothing is divided by what may vanish, and no curved equation is solved;
           near-linear time in the number of equations.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Sequence

from planarc.core.data import Data
from planarc.ir.dae import Dae
from planarc.ir.expr import Expr, Exprs, Op, Substitution, postorder
from planarc.ir.sorted import Alias
from planarc.structure.linear import Contents, coefficients, solve_affine
from planarc.structure.signs import Signs

# Where it counts: an enumeration looks up its members by a function.
_SYMBOL, _NEG, _ADD = Op.SYMBOL, Op.NEG, Op.ADD
_SHORT = 6  # unknowns of an equation that is looked at whenever one of them vanishes


class Live(Data):
    """An equation that remains, in the symbols that remain."""

    index: int  # of the equation in the Dae
    left: Expr
    right: Expr
    residual: Expr  # left - right
    rates: tuple[Expr, ...] = ()  # the first derivatives of `right`, where they are given


class Elimination(Data):
    kept: tuple[str, ...]  # variables that remain, in declaration order
    live: tuple[Live, ...]
    vanished: tuple[int, ...]  # equations that came to 0 = 0: they follow from others
    aliases: tuple[Alias, ...]
    rewrite: Substitution  # any expression of the Dae in the symbols that remain


def eliminate_aliases(dae: Dae, signs: Signs) -> Elimination:
    search = _Search(dae, signs)
    search.run()
    rewrite = search.substitution()
    live = []
    vanished = []
    for i, equation in enumerate(dae.equations):
        if i in search.spent:
            continue
        left, right = rewrite(equation.left), rewrite(equation.right)
        residual = dae.table.sub(left, right)
        if residual is dae.table.zero:
            vanished.append(i)
        else:
            live.append(Live(i, left, right, residual, tuple(map(rewrite, equation.rates))))
    kept = tuple(v.name for v in dae.variables if search.forest.is_root(v.name))
    return Elimination(kept, tuple(live), tuple(vanished), search.aliases(rewrite), rewrite)


class Forest:
    """The meaning of each name: sign * (root differentiated `shift` times), or a value."""

    def __init__(self, table: Exprs) -> None:
        self._table = table
        self._parent: dict[str, tuple[int, str, int]] = {}
        self._value: dict[str, Expr] = {}

    def is_root(self, name: str) -> bool:
        return name not in self._parent and name not in self._value

    def find(self, name: str) -> tuple[int, str, int]:
        """(sign, root, shift) of a name; shortens the path on the way."""
        if name not in self._parent:
            return 1, name, 0
        trail = []
        while name in self._parent:
            trail.append(name)
            name = self._parent[name][1]
        sign, shift = 1, 0
        for child in reversed(trail):
            own_sign, _, own_shift = self._parent[child]
            sign, shift = sign * own_sign, shift + own_shift
            self._parent[child] = (sign, name, shift)
        return sign, name, shift

    def resolve(self, symbol: Expr) -> Expr:
        name, order = symbol.data
        if self.is_root(name):
            return symbol
        sign, root, shift = self.find(name)
        order += shift
        if root in self._value:
            found = self._table.zero if order else self._value[root]
        else:
            found = self._table.symbol(root, order)
        return found if sign > 0 else self._table.neg(found)

    def join(self, name: str, sign: int, root: str, shift: int) -> None:
        """The root `name` is sign * der^shift(root)."""
        self._parent[name] = (sign, root, shift)

    def settle(self, name: str, value: Expr) -> None:
        self._value[name] = value


class _Search:
    def __init__(self, dae: Dae, signs: Signs) -> None:
        self.table = dae.table
        self.signs = signs
        self.forest = Forest(dae.table)
        self.names = [v.name for v in dae.variables]
        self.key = {v.name: (-v.state_select, v.protected, i) for i, v in enumerate(dae.variables)}
        self.contents = Contents(self.key.__contains__)
        self.parameters = {p.name for p in dae.parameters}
        self.numbers = {
            self.table.symbol(p.name): p.value
            for p in dae.parameters
            if p.value.is_const and not p.settable
        }
        self.equations = dae.equations
        self.residuals: dict[int, Expr] = {}
        self.derivatives: deque[int] = deque()  # equations that may name a derivative
        self.long: deque[int] = deque()  # equations of many unknowns: looked at seldom
        self.size: dict[int, int] = {}  # unknowns when last looked at
        self.named: dict[int, frozenset[Expr]] = {}  # by which name they are known since
        self.spent: set[int] = set()  # equations that made an alias
        self.reason: dict[str, int] = {}  # which equation eliminated a name
        self.uses: dict[str, list[int]] = {name: [] for name in self.key}

    def run(self) -> None:
        self.queued = [True] * len(self.equations)
        # Most equations are plain connections: they need no residual.
        plain = (i for i, e in enumerate(self.equations) if not e.rates)
        self.queue = deque(i for i in plain if not self._try_names(i))
        inline = Substitution(self.table, self.numbers)
        for i in self.queue:
            e = self.equations[i]
            self.residuals[i] = self.table.sub(inline(e.left), inline(e.right))
            for name in {s.data[0] for s in self._unknowns(i)}:
                self.uses[name].append(i)
        while source := self.queue or self.derivatives or self.long:
            late = source is not self.queue
            i = source.popleft()
            self.queued[i] = False
            if i not in self.spent:
                self._classify(i, late)

    def _try_names(self, i: int) -> bool:
        """Two names that are equal or opposite, as they are written, or whose sum is 0."""
        e = self.equations[i]
        written, sign = (e.left, e.right), 1
        if e.right is self.table.zero and e.left.op is _ADD and len(e.left.args) == 2:
            written, sign = e.left.args, -1
        sides = []
        for side in written:
            if side.op is _NEG:
                side, sign = side.args[0], -sign
            if side.op is not _SYMBOL or side.data[1] or side.data[0] not in self.key:
                return False
            sides.append(side)
        left, right = sides
        return self._join(i, left, right, sign)

    def _unknowns(self, i: int) -> Collection[Expr]:
        """The unknowns of an equation, after what has become known of its variables. The residual
        is written anew where it has one left, or fewer than before: not for other names alone."""
        residual = self.residuals[i]
        before = self.contents(residual)
        named = self.named.get(i, before)
        stale = [s for s in named if s.data[0] in self.reason]
        if not stale:
            return named
        found = [self.contents(self.forest.resolve(s)) for s in sorted(stale)]
        named = named.difference(stale).union(*found)
        if len(named) < max(2, len(before)):
            changed = {s: self.forest.resolve(s) for s in before if s.data[0] in self.reason}
            self.residuals[i] = Substitution(self.table, changed)(residual)
            named = self.contents(self.residuals[i])
        self.named[i] = named
        return named

    def _classify(self, i: int, late: bool) -> None:
        """Derivatives wait until no constant is left to be found: der(constant) is zero."""
        unknowns = self._unknowns(i)
        self.size[i] = len(unknowns)
        if len(unknowns) == 1:
            self._try_constant(i, *unknowns)
        elif len(unknowns) == 2:
            if late or not any(s.data[1] for s in unknowns):
                residual = self.residuals[i]
                a, b = self.contents(residual)
                self._join(i, a, b, self._pair_sign(residual, a, b))
            else:
                self.derivatives.append(i)

    def _try_constant(self, i: int, symbol: Expr) -> None:
        residual = self.residuals[i]
        if symbol.order:
            return
        factor = coefficients(self.table, self.contents, residual)[symbol]
        if factor is None or not self.signs.never_zero(factor):
            return
        value = solve_affine(self.table, self.contents, residual, self.table.zero, symbol, factor)
        if not self._is_constant(value):
            return
        self.forest.settle(symbol.name, value)
        self._spend(i, symbol.name)

    def _is_constant(self, value: Expr) -> bool:
        """Whether it holds only parameters: it stays the same while running, events included."""
        return not any(
            e.op in (Op.TIME, Op.PRE, Op.EVENT)
            or (e.op is Op.SYMBOL and e.name not in self.parameters)
            for e in postorder((value,))
        )

    def _join(self, i: int, a: Expr, b: Expr, sign: int) -> bool:
        """Make one of a = sign*b stand for the other, if that can be."""
        own, name, order = self._signed(a)
        others, root, shift = self._signed(b)
        sign *= own * others
        if not sign or name == root or (order and shift):
            return False
        if order or (not shift and self.key[name] < self.key[root]):
            name, root, shift = root, name, order
        self.forest.join(name, sign, root, shift)
        self.uses[root].extend(self.uses[name])
        self._spend(i, name)
        return True

    def _signed(self, symbol: Expr) -> tuple[int, str, int]:
        """The sign, name and order that one of an equation's two unknowns has come to."""
        name, order = symbol.data
        sign, root, shift = self.forest.find(name)
        return sign, root, order + shift

    def _pair_sign(self, residual: Expr, a: Expr, b: Expr) -> int:
        """1 for a = b, -1 for a = -b, 0 when the equation says something else."""
        if residual.op is not _ADD or len(residual.args) != 2:
            return 0
        factors = {}
        for term in residual.args:
            number, symbol = 1.0, term
            if symbol.op is _NEG:
                number, symbol = -1.0, symbol.args[0]
            if symbol.op is Op.MUL and len(symbol.args) == 2 and symbol.args[0].is_const:
                number, symbol = number * symbol.args[0].data, symbol.args[1]
            factors[symbol] = number
        if factors.keys() != {a, b} or abs(factors[a]) != abs(factors[b]):
            return 0
        return -1 if factors[a] == factors[b] else 1

    def _spend(self, i: int, name: str) -> None:
        """Equation i has eliminated a name: whatever holds that name is looked at again."""
        self.spent.add(i)
        self.reason[name] = i
        for j in self.uses[name]:
            if not self.queued[j] and j not in self.spent:
                self.queued[j] = True
                (self.queue if self.size.get(j, 0) <= _SHORT else self.long).append(j)

    def substitution(self) -> Substitution:
        mapping = dict(self.numbers)
        for e in self.table.symbols():
            if e.data[0] in self.key:
                found = self.forest.resolve(e)
                if found is not e:
                    mapping[e] = found
        return Substitution(self.table, mapping)

    def aliases(self, rewrite: Substitution) -> tuple[Alias, ...]:
        found = []
        for name in self.names:
            if self.forest.is_root(name):
                continue
            target = rewrite(self.table.symbol(name))
            sign = 1
            if (
                target.op is _NEG
                and target.args[0].op is _SYMBOL
                and (target.args[0].name in self.key)
            ):
                target, sign = target.args[0], -1
            found.append(Alias(name, target, sign, self.reason[name]))
        return tuple(found)


def orders_needed(
    elimination: Elimination, contents: Contents, other: Sequence[Expr]
) -> dict[str, int]:
    """The least order of differentiation of each kept variable, for aliases and `other`."""
    least = dict.fromkeys(elimination.kept, 0)
    targets = [a.target for a in elimination.aliases]
    for expression in (*targets, *other):
        for symbol in contents(expression):
            name, order = symbol.data
            least[name] = max(least[name], order)
    return least
