"""Statement lists from expressions: shared nodes become temporaries.

In:   values of one section (a function of the generated code), in their order
Out:  `Let` lists; what is used twice is computed once, what is used once stays inline

Example, with `cos(phi)` shared:

    x = L*cos(phi)            $t1 := cos(phi)
    y = M*cos(phi) + x        x := L*$t1
                              y := M*$t1 + x

Needs:     every symbol is assigned once in a section, before its first use.
Promises:  temporaries are numbered in the order of their creation; a value that some
           symbol already holds is taken from that symbol; nothing is simplified or
           reordered here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from planarc.ir.expr import Expr, Exprs, Op, postorder
from planarc.ir.program import Let
from planarc.ir.sorted import Assignment

#: Depth and length at which formulas are broken: compilers are recursive.
DEEPEST = 30
LONGEST = 40
_TERMS = (Op.ADD, Op.MUL)

# Where it counts: an enumeration looks up its members by a function.
_CONST, _SYMBOL, _NEG = Op.CONST, Op.SYMBOL, Op.NEG


class Temporaries:
    """Makes the temporaries of one program: `$t1`, `$t2`, ..."""

    def __init__(self, table: Exprs, count: int = 0) -> None:
        self._table = table
        self._count = count

    def new(self) -> Expr:
        self._count += 1
        return self._table.symbol(f"$t{self._count}")


def is_trivial(e: Expr) -> bool:
    """A leaf or its negative: not worth a temporary."""
    return not e.args or (e.op is _NEG and not e.args[0].args)


def shared(values: Iterable[Expr]) -> set[Expr]:
    """The nodes that are worth a temporary: used more than once by the values."""
    roots = Counter(values)
    found = list(roots)
    used: set[Expr] = set(found)
    again = {e for e, n in roots.items() if n > 1}
    for e in found:
        for a in e.args:
            if a in used:
                again.add(a)
            else:
                used.add(a)
                found.append(a)
    return {e for e in again if not is_trivial(e)}


def invariants(values: Iterable[Expr], varying: set[Expr]) -> list[Expr]:
    """The largest parts of the values that do not depend on the symbols `varying`."""
    roots = list(values)
    varies: dict[Expr, bool] = {}
    found: dict[Expr, None] = {}
    for e in postorder(roots):
        varies[e] = e in varying or any(varies[a] for a in e.args)
        if varies[e]:
            found.update((a, None) for a in e.args if not varies[a] and not is_trivial(a))
    found.update((e, None) for e in roots if not varies[e] and not is_trivial(e))
    return list(found)


def name_parts(table: Exprs, formulas: Iterable[Expr], names: set[str]) -> dict[Expr, Expr]:
    """The largest parts that parameters alone make, with symbols, in the order of evaluation.

    They are computed once, before the run: tau = -m*g*(L/2)*sin(phi) becomes
    $p1 := L/2, tau = -m*g*$p1*sin(phi). `names` are parameters and constant unknowns.
    """
    constant: set[Expr] = set()
    found: dict[Expr, None] = {}
    roots = list(formulas)
    for e in postorder(roots):
        if not e.args:
            if e.op is _CONST or (e.op is _SYMBOL and not e.data[1] and e.data[0] in names):
                constant.add(e)
        elif constant.issuperset(e.args):
            constant.add(e)
        elif not constant.isdisjoint(e.args):
            for a in e.args:
                if a in constant and not is_trivial(a):
                    found[a] = None
    found.update((e, None) for e in roots if e in constant and not is_trivial(e))
    return {e: table.symbol(f"$p{i}") for i, e in enumerate(found, 1)}


class Lister:
    """Writes the statements of one section; remembers what is computed already."""

    def __init__(
        self,
        table: Exprs,
        temporaries: Temporaries,
        values: Iterable[Expr],
        known: Mapping[Expr, Expr] | None = None,
    ) -> None:
        self._table = table
        self._temporaries = temporaries
        self._shared = shared(values)
        self._known: dict[Expr, Expr] = dict(known or {})  # node -> how to write it from here on
        self._depths: dict[Expr, int] = {}  # of what is written inline
        self._trail: list[Expr] = []  # the keys of `_known` in their order

    def let(self, out: list[Let], target: Expr, value: Expr, equation: int | None = None) -> None:
        """target := value, and before it the temporaries that it needs."""
        if value not in self._known and not is_trivial(value):
            for a in value.args:
                if a.args:
                    self.value(out, a)
            written = self._node(out, value)
            self._remember(value, target)
        else:
            written = self.value(out, value)
        out.append(Let(target, written, equation))

    def assigned(self, assignments: Iterable[Assignment]) -> list[Let]:
        """The statements of assignments."""
        out: list[Let] = []
        for a in assignments:
            self.let(out, a.target, a.value, a.equation)
        return out

    def name(self, out: list[Let], symbol: Expr, value: Expr) -> None:
        """Assign as `let` does; a value that is known or trivial only gets the symbol as a name."""
        if is_trivial(self._known.get(value, value)):
            self._remember(symbol, self.value(out, value))
        else:
            self.let(out, symbol, value)

    def hold(self, out: list[Let], values: Sequence[Expr]) -> None:
        """Compute values into temporaries, even those that are used once."""
        for value in values:
            written = self.value(out, value)
            if written.args:
                self._remember(value, self._named(out, written))

    def value(self, out: list[Let], root: Expr) -> Expr:
        """The value as it is to be written; its temporaries are appended to `out`."""
        known = self._known
        stack = [root] if root.args else []
        while stack:
            e = stack[-1]
            if e in known:
                stack.pop()
            else:
                depth = len(stack)
                for a in reversed(e.args):
                    if a.args and a not in known:
                        stack.append(a)
                if len(stack) == depth:
                    stack.pop()
                    self._trail.append(e)
                    known[e] = self._written(out, e)
        return known.get(root, root)

    def _written(self, out: list[Let], e: Expr) -> Expr:
        new = self._node(out, e)
        if e in self._shared or self._depths[new] > DEEPEST:
            return self._named(out, new)
        return new

    def _node(self, out: list[Let], e: Expr) -> Expr:
        """The node over its arguments as they are written."""
        args = tuple(map(self._known.get, e.args, e.args))
        while len(args) > LONGEST and e.op in _TERMS:  # its first terms by themselves
            args = (self._named(out, self._table.node(e.op, args[:LONGEST])), *args[LONGEST:])
        new = e if args == e.args else self._table.node(e.op, args, e.data)
        depths, depth = self._depths, 0
        for a in args:
            if a.args and depths.get(a, 0) > depth:
                depth = depths[a]
        depths[new] = 1 + depth
        return new

    def _named(self, out: list[Let], value: Expr) -> Expr:
        temporary = self._temporaries.new()
        out.append(Let(temporary, value))
        return temporary

    def _remember(self, e: Expr, written: Expr) -> None:
        if e not in self._known:
            self._trail.append(e)
        self._known[e] = written

    # What is computed only in a part of a section (the residuals of a block) must be
    # forgotten behind it.

    def mark(self) -> int:
        return len(self._trail)

    def forget(self, mark: int) -> None:
        for e in self._trail[mark:]:
            del self._known[e]
        del self._trail[mark:]
