"""Start values of discrete variables, from the initial equations that decide them.

In:   Model, initial equations, discrete variables, discrete equations, when-clauses; values before
      the start that count where nothing else decides them (`free_starts`)
Out:  the initial equations of continuous variables; discrete variables with their start values;
      when-clauses of `initial()` for what is decided or looked at only there

What when-clauses set has its start value at the start. What an equation gives has the value of
that equation: it is followed to the variable whose value *before* the start decides it. Where
there is none, or where two initial equations decide one variable, the run looks at the start
whether the equation holds.

Example:

    initial equation                               initial equation
      active = true;                                 pre(next) = true;
      pre(next) = pre(now);              ->          pre(now) = true;
    equation
      active = now;  now = pre(next);

Reference: Modelica Language Specification 3.6, section 8.6.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from functools import cached_property

from msgspec.structs import replace

from planarc.core.diagnostic import error
from planarc.ir import dae
from planarc.ir.actions import rewrite_action
from planarc.ir.expr import Expr, Op, Substitution, postorder, symbols
from planarc.lower.equations import Lowered, acts_at_start, at_start_only, set_at_start
from planarc.lower.scope import Model
from planarc.lower.values import expr

#: A discrete Real holds what an initial equation says with this relative error.
_ALIKE = 1e-9


def start_discretes(
    model: Model,
    initial: Sequence[dae.Equation],
    loose: Sequence[dae.Equation],
    discretes: Sequence[dae.Variable],
    equations: Sequence[dae.Equation],
    into: Lowered,
) -> tuple[list[dae.Equation], list[dae.Variable], list[str]]:
    """The initial equations left over, the discrete variables with their start values, and those
    whose values before the start the start finds.

    A value of unknowns is set by a when-clause of `initial()`; where the variable is fixed, it is a
    condition for these unknowns. Raises PlanarcError (L334, L335).
    """
    starts = _Starts(model, discretes, equations, into)
    rest = [equation for equation in initial if not starts.take(equation)]
    for equation in loose:
        starts.decide(equation)
    rest.extend(starts.left_over())
    values = starts.values()
    changed = [
        replace(v, start=values[v.name], fixed=True) if v.name in values else v for v in discretes
    ]
    return rest, changed, starts.found


class _Starts:
    def __init__(
        self,
        model: Model,
        discretes: Sequence[dae.Variable],
        equations: Sequence[dae.Equation],
        into: Lowered,
    ) -> None:
        table = model.table
        self._model, self._into = model, into
        self._declared = {v.name: v for v in discretes}
        self._given: dict[str, dae.Equation] = {}
        model.parameters.add(dae.START_TIME)
        self._at_start = Substitution(table, {table.time: table.symbol(dae.START_TIME)})
        held = dae.set_by_whens(into.whens)
        self.found: list[str] = []
        self._sides: dict[str, list[Expr]] = {}
        self._kept: set[str] = set()  # by an algorithm that gives them values, too
        for e in equations:
            for one, other in ((e.left, e.right), (e.right, e.left)):
                if not one.is_symbol or one.name not in model.discretes or one.name in held:
                    continue
                if e.clock is not None or (
                    e.assigned and table.pre(one.name) in postorder((other,))
                ):
                    self._kept.add(one.name)
                else:
                    self._sides.setdefault(one.name, []).append(other)

    def take(self, equation: dae.Equation) -> bool:
        """Whether the equation is about a discrete variable, and so done with."""
        left, table = equation.left, self._model.table
        if left.op not in (Op.SYMBOL, Op.PRE) or left.name not in self._model.discretes:
            return False
        right = self._followed(self._at_start(equation.right))
        if left.is_symbol and left.name in self._sides:
            root = self._followed(left)
            while root.op is Op.NOT:
                root, right = root.args[0], table.not_(right)
            decided = root.op in (Op.SYMBOL, Op.PRE) and root.name in self._model.discretes
            if decided and self._is_known(right):
                self._give(root.name, replace(equation, right=right))
                return True
            if table.pre(left.name) in postorder((root,)) and self._is_known(right):
                self._give(left.name, replace(equation, right=right))
            self._look(equation, left)
        elif self._is_known(right):
            self._give(left.name, replace(equation, right=right))
        elif left.op is Op.PRE and self._is_only_held(left.name):
            now = replace(equation, left=table.symbol(left.name))
            if left.name in self._given:
                self._look(now, left)
            else:
                self._set(now)
                self.found.append(left.name)
        elif left.op is Op.PRE:
            message = f"the start value of `pre({left.name})` must be known before the start"
            hint = "use parameters without `fixed=false`, or let nothing else give "
            hint += f"`{left.name}` a value at the start"
            raise error("L334", message, equation.span, hint=hint)
        elif self._declared[left.name].fixed:
            return False
        else:
            self._set(equation)
        return True

    def decide(self, equation: dae.Equation) -> None:
        """Take an equation about the value before the start, where nothing else decides it."""
        name = equation.left.name
        if name not in self._given and self._is_only_held(name):
            self.take(equation)

    def left_over(self) -> Iterator[dae.Equation]:
        """Take again what hangs on variables that a later equation lets the start set."""
        while hanging := [n for n, e in self._given.items() if not self._is_known(e.right)]:
            for equation in map(self._given.pop, hanging):
                if not self.take(equation):
                    yield equation

    def _set(self, equation: dae.Equation) -> None:
        self._into.whens.append(set_at_start(self._model, equation))
        self._set_at_start.add(equation.left.name)

    @cached_property
    def _set_at_start(self) -> set[str]:
        """The variables that when-clauses of `initial()` give their values."""
        return {
            action.name
            for when in self._into.whens
            for condition, actions in when.branches
            for action in actions
            if isinstance(action, dae.SetDiscrete) and acts_at_start(self._model, condition)
        }

    def _is_only_held(self, name: str) -> bool:
        """Whether a variable has at the start the value that it had before."""
        given = name in self._sides or name in self._kept or name in self._set_at_start
        return not (given or self._declared[name].fixed)

    def values(self) -> dict[str, Expr]:
        """Start values as expressions of parameters alone."""
        found: dict[str, Expr] = {}
        return {name: self._start(name, found, ()) for name in self._given}

    def _start(self, name: str, found: dict[str, Expr], path: tuple[str, ...]) -> Expr:
        """The start value of a variable, which stands in `found` if it was asked for before."""
        if name not in self._given:
            return self._default(name)
        if name not in found:
            if name in path:
                message = f"the start value of `{name}` depends on itself"
                raise error("L335", message, self._given[name].span)
            value = self._given[name].right
            read = [e for e in postorder((value,)) if e.op in (Op.SYMBOL, Op.PRE)]
            named = [e for e in read if e.name in self._declared]
            inner = {e: self._start(e.name, found, (*path, name)) for e in named}
            found[name] = Substitution(self._model.table, inner)(value)
        return found[name]

    def _default(self, name: str) -> Expr:
        v, table = self._declared[name], self._model.table
        if v.start is not None:
            return expr(v.start)
        return table.false if v.kind is dae.Kind.BOOLEAN else table.zero

    def _followed(self, e: Expr, path: tuple[str, ...] = ()) -> Expr:
        """The expression with discrete variables that equations give put in."""
        inner = {
            s: self._given_by(s, (*path, s.name))
            for s in symbols(e)
            if s.name in self._sides and s.name not in path
        }
        return Substitution(self._model.table, inner)(e)

    def _given_by(self, symbol: Expr, path: tuple[str, ...]) -> Expr:
        """What gives a variable its value: rather an expression than another name for it."""
        sides = sorted(self._sides[symbol.name], key=lambda e: e.is_symbol)
        ways = (self._followed(e, path) for e in sides if not e.is_symbol or e.name not in path)
        return next((e for e in ways if not e.is_symbol or e.name not in self._sides), symbol)

    def _is_known(self, e: Expr) -> bool:
        """Whether it follows from parameters and start values."""
        known = all(
            n.op is not Op.EVENT
            and not (n.is_symbol and (n.name in self._sides or n.name in self._set_at_start))
            and not dae.is_initial(n)
            for n in postorder((e,))
        )
        return known and self._model.is_steady(e)

    def _give(self, name: str, equation: dae.Equation) -> None:
        """Let the value before the start be what the equation says; where it is decided already,
        one of both may decide another variable that is the same then."""
        table, before = self._model.table, self._given.get(name)
        declared = self._declared[name]
        if before is None and declared.fixed and declared.start is not None:
            value = expr(declared.start)
            before = replace(equation, left=table.pre(name), right=value)
        if before is None:
            self._given[name] = equation
            return
        for one, other in ((before, equation), (equation, before)):
            same = one.right
            lone = same.op in (Op.SYMBOL, Op.PRE) and same.name in self._declared
            if lone and same.name != name and same.name not in self._given:
                self._given[same.name] = replace(one, left=same, right=table.pre(name))
                self._given[name] = other
                return
        if before.right is not equation.right:
            self._look(equation, table.pre(name))

    def _look(self, equation: dae.Equation, left: Expr) -> None:
        """Look at the start whether the equation holds."""
        table, right = self._model.table, equation.right
        holds = table.equal(left, right)
        if self._declared[left.name].kind is dae.Kind.REAL:
            size = table.mul(table.const(_ALIKE), table.call("abs", right))
            holds = table.less_equal(table.call("abs", table.sub(left, right)), size)
        message = dae.Message((f"the initial equation {equation.shown} does not hold",))
        told = dae.Assertion(holds, message, component=equation.component, span=equation.span)
        self._into.whens.append(at_start_only(self._model, equation, told))


def know_before(model: dae.Dae, names: Collection[str]) -> dae.Dae:
    """The model whose `pre(d)` of these variables, which the start finds, is at the start the value
    that they have there: in `e = pre(d) + 1` stands `if initial() then d else pre(d)`."""
    if not names:
        return model
    t = model.table
    starting = t.symbol(dae.INITIAL)
    known = {t.pre(name): t.if_(starting, t.symbol(name), t.pre(name)) for name in names}
    put_in = Substitution(t, known)

    def equations(found: Iterable[dae.Equation]) -> tuple[dae.Equation, ...]:
        return tuple(replace(e, left=put_in(e.left), right=put_in(e.right)) for e in found)

    def when(clause: dae.When) -> dae.When:
        branches = (
            (condition, tuple(rewrite_action(a, t, put_in) for a in actions))
            for condition, actions in clause.branches
        )
        return replace(clause, branches=tuple(branches))

    return replace(
        model,
        equations=equations(model.equations),
        initial_equations=equations(model.initial_equations),
        discrete_equations=equations(model.discrete_equations),
        relations=tuple(replace(r, zero=put_in(r.zero)) for r in model.relations),
        whens=tuple(map(when, model.whens)),
        assertions=tuple(rewrite_action(a, t, put_in) for a in model.assertions),
    )
