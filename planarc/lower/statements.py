"""Statements run one after the other on expressions instead of numbers.

Example:  after  `a := 2*x; if p > 0 then a := a + 1; end if;`  the variable a has the
value `if 0 < p then 2*x + 1 else 2*x`.

An `if` whose condition is not known is run on both sides and joined. A `while`,
`break` or `return` that hangs on such a condition splits the run: each way goes on
to the end by itself, with its own values, and the ends are joined. So a search
through a table of n entries, `while x > table[i] loop i := i + 1; end while;`,
becomes a choice between n results.

Serves functions (`functions`) and the algorithm sections of models (`algorithms`). The file is long
because the ways of a run are split and joined by all kinds of statements.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, TypeAlias

from msgspec import Struct, field
from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Misfit, Related, error
from planarc.core.prose import both, listed
from planarc.core.source import Span
from planarc.ir import dae, flat
from planarc.ir.expr import Expr, Exprs
from planarc.ir.flatwalk import assigned_in, nodes_of, set_by
from planarc.lower import scalar
from planarc.lower.assignment import store, zero_of
from planarc.lower.scope import Endless, OutsideArray, Scope, UnknownCourse, outside_of_when
from planarc.lower.unset import Unset, join
from planarc.lower.values import Value, expect_size, expr, fixed_dims, known_of
from planarc.runtime.tensor import elements, shape_of

MAX_TURNS = 50_000  # of all loops of one call whose conditions are known
MAX_WAYS = 1_000  # ways through one call
MAX_STILL = 50  # turns of a loop that each may be the last, after which the same is known
MAX_ENTRIES = 1_000_000  # of one array
#: Steps of a range are taken for so many more of them: 0.3/0.1 is 2.9999999999999996.
_ROUNDED = 1 + 1e-15


class _Body(Data):
    """Statements that are left to run, from a position on."""

    statements: Sequence[flat.Statement]
    position: int = 0


class _For(Data):
    statement: flat.ForStatement
    domain: Sequence[Value]
    hidden: Value | None  # what the iterator's name meant outside
    turn: int = 0


class _While(Data):
    statement: flat.WhileStatement
    ways: int  # of the call before this turn
    known: tuple[object, ...] = ()  # of the variables that it assigns, before this turn
    still: int = 0  # the turns since `known` changed


Frame = _Body | _For | _While

#: Among the values of a turn that is run for all: whether `break` or `return` has left the loop.
LEFT, RETURNED = "$left", "$returned"


class Header(Data):
    """What asks for another turn of a loop, and what ends one."""

    loop: flat.WhileStatement | flat.ForStatement
    holds: Callable[[Runner], Expr]
    step: Callable[[Runner], None] = lambda _: None
    counted: str = ""  # what counts the turns, where something does


#: What runs loops that hang on what is not known as loops.
Roll: TypeAlias = "Callable[[Runner, Header], None]"


class Runner(Struct):
    """The state of one way through the statements. `values` are the variables that have one."""

    scope: Scope
    label: str  # what is run, for messages
    span: Span  # where it was called
    events: bool = False  # relations make events (algorithm sections of models)
    values: dict[str, Value] = field(default_factory=dict)
    path: Expr | None = None  # what holds on this way; None: nothing is unknown so far
    frames: list[Frame] = field(default_factory=list)  # the innermost one last
    forks: list[tuple[Expr, Runner]] = field(default_factory=list)  # other ways, not yet run
    ways: list[int] = field(default_factory=lambda: [1])  # counted over all ways of the call
    turns: list[int] = field(default_factory=lambda: [0])  # likewise
    sizes: dict[str, flat.Dims] = field(default_factory=dict)  # of the variables declared
    unset: Unset = Unset()  # where some of `values` have none, in a function
    function: flat.Function | None = None
    roll: Roll | None = None  # without, loops that hang on what is not known are refused
    handlers: ClassVar[Mapping[type, Callable[[Any, Any], None]]] = {}

    def run_body(self, statements: Sequence[flat.Statement]) -> None:
        """Run to the end, all ways, and join them in `values`."""
        outer, self.frames = self.frames, [_Body(statements)]
        other_forks, self.forks = self.forks, []
        path = self.path
        self._finish()
        self.frames, self.forks, self.path = outer, other_forks, path

    def _finish(self) -> None:
        """Run this way to its end, then those that were split off, and join them."""
        self._go()
        for condition, other in reversed(self.forks):
            other._finish()
            self._meet(condition, other, self.span)

    def _go(self) -> None:
        while self.frames:
            match self.frames.pop():
                case _Body(statements, position) if position < len(statements):
                    self.frames.append(_Body(statements, position + 1))
                    statement = statements[position]
                    self.handlers[type(statement)](self, statement)
                case _For() as loop:
                    self._next_for(loop)
                case _While() as loop:
                    self._next_while(loop)

    def split(self, condition: Expr, loop: flat.WhileStatement | None = None) -> Runner:
        """Another way from here on, for when `condition` holds; this one goes on without. `loop` is
        the one that it leaves, if any."""
        self.ways[0] += 1
        if self.ways[0] > MAX_WAYS and loop is not None:
            raise self._endless(loop)
        if self.ways[0] > MAX_WAYS:
            raise self.refused(f"a choice between more than {MAX_WAYS} ways", self.span)
        other = replace(self, values=dict(self.values), frames=list(self.frames), forks=[])
        other.path = self.on_path(condition)
        self.path = self.on_path(self.scope.table.not_(condition))
        self.forks.append((condition, other))
        return other

    def on_path(self, condition: Expr) -> Expr:
        return condition if self.path is None else self.scope.table.and_(self.path, condition)

    def _meet(self, condition: Expr, then: Runner, span: Span) -> None:
        """Join this way with another one, to which `condition` leads."""
        ways = (then.unset, then.values), (self.unset, self.values)
        self.unset = join(self.scope.table, condition, *ways)
        self._join(condition, then.values, self.values, span)

    def _join(
        self, condition: Expr, then: Mapping[str, Value], otherwise: dict[str, Value], span: Span
    ) -> None:
        """Put each variable as it is on either way into `otherwise`."""
        here = self.here()
        for name, value in then.items():
            other = otherwise.get(name)
            if other is None:  # assigned on one way only
                otherwise[name] = value
            elif shape_of(other) != shape_of(value):
                if other != value:
                    del otherwise[name]  # has no value that holds on both ways
            elif other is not value:
                otherwise[name] = scalar.choose(here, condition, value, other, span)

    # Values

    def declare(self, variable: flat.Variable) -> None:
        self.sizes[variable.name] = dims = self.dims(variable)
        if variable.binding is not None:
            value = self.value(variable.binding)
            expect_size(f"`{variable.name}`", dims, value, variable.binding.span)
            self.values[variable.name] = value
            return
        type_ = variable.type.with_dims(_unwritten(variable, dims))
        has_parts = type_.base is flat.Base.RECORD or bool(type_.dims)
        if has_parts and None not in type_.dims:
            # Entries and fields may be assigned one by one; until then they are zero, and
            # arrays that may grow are empty.
            _bound(math.prod(fixed_dims(type_)), variable)
            self.values[variable.name] = zero_of(type_, self.scope.table)

    def dims(self, variable: flat.Variable) -> flat.Dims:
        """The dimensions, with those that depend on the inputs computed."""
        dims = list(variable.type.dims)
        for k, size in enumerate(variable.sizes):
            if dims[k] is None and size is not None:
                dims[k] = self._entries(size, variable)
        return tuple(dims)

    def _entries(self, size: flat.Expression, variable: flat.Variable) -> int | None:
        value = self.value(size)
        if not isinstance(value, Expr):
            raise error("L323", f"a size of `{variable.name}` is no number", size.span)
        if not value.is_const:
            return None
        _bound(value.data, variable)
        return int(value.data)

    def here(self) -> Scope:
        outer, path, unset = self.scope, self.whole_path(), self.unset.conditions
        return Scope(
            outer.model, self.values, self.events, outer.at_event, outer.depth, path, unset,
            self.function,
        )  # fmt: skip

    def whole_path(self) -> Expr | None:
        """The condition under which the present statement is run, from the outermost call on."""
        outer = self.scope.path
        return outer if self.path is None else self.scope.where(self.path).path

    def value(self, e: flat.Expression) -> Value:
        return scalar.lower_expression(self.here(), e)

    def refused(self, what: str, span: Span, hint: str | None = None) -> UnknownCourse:
        return UnknownCourse(
            Diagnostic(
                "L322",
                f"{what} in {self.label} cannot be turned into equations",
                span,
                hint=hint or "let the condition depend on values that are known at compile time",
                related=(Related("called here", self.span),),
            )
        )

    def outside(self, problem: OutsideArray) -> OutsideArray:
        """The error of a subscript, with the turn of the loops in which it stands, and the call."""
        found = problem.diagnostics[0]
        if found.related:  # told by a call inside of this one
            return problem
        loops = (f.statement.iterator for f in self.frames if isinstance(f, _For))
        turns = [(name, self.values.get(name)) for name in loops]
        at = [f"`{n}` = {v.data:g}" for n, v in turns if isinstance(v, Expr) and v.is_const]
        hint = f"this is at {listed(at)}: let the loop run over fewer values" if at else found.hint
        called = (Related("called here", self.span),)
        return OutsideArray(replace(found, hint=hint, related=called))

    # Statements

    def assign(self, s: flat.Assignment) -> None:
        here = self.here()
        self._store(here, s.target, scalar.lower_expression(here, s.value))
        self._set(s)

    def assign_tuple(self, s: flat.TupleAssignment) -> None:
        here = self.here()
        given = tuple(scalar.lower_expression(here, a) for a in s.value.arguments)
        results = here.model.inline(here, s.value.function, given, s.span)
        for target, value in zip(s.targets, results, strict=False):
            if target is not None:
                self._store(self.here(), target, value)
        self._set(s)

    def _store(self, here: Scope, target: flat.Target, value: Value) -> None:
        if isinstance(target, flat.Reference) and not target.subscripts:
            sizes = self.sizes.get(target.name, target.type.dims)
            expect_size(f"`{target.name}`", sizes, value, target.span)
        store(here, self.values, target, value)

    def _set(self, s: flat.Assignment | flat.TupleAssignment) -> None:
        if self.unset.conditions:
            self.unset = self.unset.having({v.name for v in set_by(s)})

    def branch(self, s: flat.IfStatement) -> None:
        for i, (test, body) in enumerate(s.branches):
            condition = expr(self.value(test))
            if not condition.is_const:
                rest = flat.IfStatement(s.span, s.component, s.branches[i + 1 :], s.otherwise)
                self._unknown_branch(condition, body, rest)
                return
            if condition.data:
                self.frames.append(_Body(body))
                return
        self.frames.append(_Body(s.otherwise))

    def _unknown_branch(
        self, condition: Expr, body: Sequence[flat.Statement], rest: flat.IfStatement
    ) -> None:
        if _leaves(body) or _leaves((rest,)):
            self.split(condition).frames.append(_Body(body))
            self.frames.append(_Body((rest,)))
            return
        path, then = self.path, replace(self, values=dict(self.values))
        then.path = self.on_path(condition)
        then.run_body(body)
        self.path = self.on_path(self.scope.table.not_(condition))
        self.run_body((rest,))
        self.path = path
        self._meet(condition, then, rest.span)

    def loop_for(self, s: flat.ForStatement) -> None:
        if isinstance(s.range, flat.Range) and s.range.type.dims[0] is None:
            start, step, stop = scalar.range_bounds(self.here(), s.range)
            if self.roll and step.is_const and not (start.is_const and stop.is_const):
                self._roll_for(self.roll, s, start, step, stop)
                return
            if not stop.is_const and start.is_const and step.is_const and not _leaves(s.body):
                self._open_for(s, start.data, step.data, stop)
                return
        domain = elements(self.value(s.range))
        self.frames.append(_For(s, domain, self.values.get(s.iterator)))

    def _next_for(self, loop: _For) -> None:
        name = loop.statement.iterator
        if loop.turn < len(loop.domain):
            self._count_turn(loop.statement)
            self.values[name] = loop.domain[loop.turn]
            self.frames += [replace(loop, turn=loop.turn + 1), _Body(loop.statement.body)]
        else:
            self._forget(loop)

    def _open_for(self, s: flat.ForStatement, start: float, step: float, stop: Expr) -> None:
        """A loop whose end is not known: turns of which each is done where it is not beyond.

        Where a turn would leave an array, the run must not come so far, which is asserted.
        """
        from planarc.lower.bounds import bounds

        t, hidden = self.scope.table, self.values.get(s.iterator)
        nothing = flat.IfStatement(s.span, s.component, (), ())
        low, high = bounds(stop)
        last = ((high if step > 0 else low) - start) / step * _ROUNDED
        whole = start == int(start) and step == int(step)
        reach = _last(t, t.const(start), t.const(step), stop)
        for turn in range(MAX_WAYS):
            if turn > last:
                break
            place = t.const(start + turn * step)
            here = t.less_equal(place, stop) if step > 0 else t.less_equal(stop, place)
            if not whole:
                here = t.less_equal(t.const(turn), reach)
            self._count_turn(s)
            before = replace(self, values=dict(self.values))
            self.values[s.iterator] = place
            try:
                with self.scope.model.undone_on_error():
                    self._unknown_branch(here, s.body, nothing)
            except (OutsideArray, Misfit) as problem:
                self.values, self.path, self.unset = before.values, before.path, before.unset
                self.frames, self.forks = before.frames, before.forks
                self._must_hold(t.not_(here), problem.diagnostics[0])
                break
        else:
            raise self.refused(f"a loop of more than {MAX_WAYS} turns, if at all,", s.span)
        self._forget(_For(s, (), hidden))

    def _must_hold(self, condition: Expr, otherwise: Diagnostic) -> None:
        """An assertion for all that comes here, with the message of what would go wrong."""
        table, path = self.scope.table, self.whole_path()
        holds = condition if path is None else table.or_(table.not_(path), condition)
        message, span = dae.Message((otherwise.message,)), otherwise.span or self.span
        self.scope.model.assertions.append(dae.Assertion(holds, message, span=span))

    def _count_turn(self, loop: flat.Statement) -> None:
        self.turns[0] += 1
        if self.turns[0] > MAX_TURNS:
            hint = _never_ends(loop) if isinstance(loop, flat.WhileStatement) else None
            raise self.refused(f"a loop of more than {MAX_TURNS} turns", loop.span, hint)

    def _forget(self, loop: _For) -> None:
        self.values.pop(loop.statement.iterator, None)
        if loop.hidden is not None:
            self.values[loop.statement.iterator] = loop.hidden

    def _roll_for(
        self, roll: Roll, s: flat.ForStatement, start: Expr, step: Expr, stop: Expr
    ) -> None:
        t, counted = self.scope.table, f"${s.iterator}"  # the turns so far
        hidden, outer = self.values.get(s.iterator), self.values.get(counted)
        last = _last(t, start, step, stop)

        def holds(turn: Runner) -> Expr:
            count = expr(turn.values[counted])
            turn.values[s.iterator] = t.add(start, t.mul(step, count))
            return t.less_equal(count, last)

        def go_on(turn: Runner) -> None:
            turn.values[counted] = t.add(expr(turn.values[counted]), t.one)

        self.values[counted] = t.zero
        roll(self, Header(s, holds, go_on, counted))
        del self.values[counted]
        if outer is not None:
            self.values[counted] = outer
        self._forget(_For(s, (), hidden))

    def loop_while(self, s: flat.WhileStatement) -> None:
        self.frames.append(_While(s, self.ways[0]))

    def _next_while(self, loop: _While) -> None:
        s = loop.statement
        self._count_turn(s)
        loop = self._watched(loop)
        condition = expr(self.value(s.condition))
        known, leaves = condition.is_const, _leaves(s.body)
        if (self.roll or (known and condition.data)) and not leaves and (hint := _never_ends(s)):
            raise self.refused("a loop without end", s.span, hint)
        if self.roll and (leaves or not known) and condition is not self.scope.table.false:
            self.roll(self, Header(s, lambda turn: expr(turn.value(s.condition))))
            return
        if not known:
            self.split(self.scope.table.not_(condition), s)  # the way that leaves the loop
        if not condition.is_const or condition.data:
            self.frames += [loop, _Body(s.body)]

    def _watched(self, loop: _While) -> _While:
        """The loop before its next turn, refused where turn after turn leaves known what was known.

        Such turns, as those of a search for a root, would go on to `MAX_WAYS`, ever longer.
        """
        if self.ways[0] == loop.ways:  # nothing was left open
            return loop
        values = (self.values.get(n) for n in assigned_in(loop.statement.body))
        known = tuple([known_of(v) for v in values if v is not None])
        still = loop.still + 1 if known == loop.known else 0
        if still > MAX_STILL:
            raise self._endless(loop.statement)
        return _While(loop.statement, self.ways[0], known, still)

    def _endless(self, loop: flat.WhileStatement) -> Endless:
        what = f"`while {loop.condition.span.text}`, of which nothing says when it ends,"
        bound = "bound its turns by a counter, as `and n < 20`, or let the condition depend on "
        bound += "values that are known at compile time"
        hint = None if _leaves(loop.body) else _never_ends(loop)
        return Endless(self.refused(what, loop.span, hint or bound).diagnostics[0])

    def leave_loop(self, s: flat.Break) -> None:
        while self.frames:
            frame = self.frames.pop()
            if isinstance(frame, _For):
                self._forget(frame)
            if not isinstance(frame, _Body):
                return
        if LEFT not in self.values:
            raise self.refused("`break` outside of a loop", s.span)
        self.values[LEFT] = self.scope.table.true

    def leave_function(self, s: flat.Return) -> None:
        self.end()

    def end(self) -> None:
        """End this way here, as by `return`."""
        self.frames.clear()
        if RETURNED in self.values:
            self.values[RETURNED] = self.scope.table.true

    def check(self, s: flat.Assert) -> None:
        here = self.here()
        found = scalar.assertion(here, s)
        if found.condition is not self.scope.table.true:
            self.scope.model.assertions.append(found)
        if found.condition is self.scope.table.false and not found.warning:
            self.unset = Unset(over=True)

    def refuse(self, s: flat.Statement) -> None:
        if isinstance(s, flat.Terminate | flat.Reinit):
            raise outside_of_when(s.span, where=" in the place of an `if`")
        raise self.refused("this statement", s.span)


def _last(t: Exprs, start: Expr, step: Expr, stop: Expr) -> Expr:
    """The number of the last entry of a range, counted from 0, as that of a known one."""
    return t.mul(t.const(_ROUNDED), t.div(t.sub(stop, start), step))


def _leaves(statements: Sequence[flat.Statement]) -> bool:
    """True when a `break` or `return` may end more than these statements."""
    stack: list[tuple[flat.Statement, bool]] = [(s, False) for s in statements]
    while stack:
        s, in_loop = stack.pop()
        match s:
            case flat.Return():
                return True
            case flat.Break() if not in_loop:
                return True
            case flat.IfStatement():
                stack.extend((b, in_loop) for _, body in s.branches for b in body)
                stack.extend((b, in_loop) for b in s.otherwise)
            case flat.ForStatement() | flat.WhileStatement():
                stack.extend((b, True) for b in s.body)
    return False


Runner.handlers = {
    flat.Assignment: Runner.assign,
    flat.TupleAssignment: Runner.assign_tuple,
    flat.IfStatement: Runner.branch,
    flat.ForStatement: Runner.loop_for,
    flat.WhileStatement: Runner.loop_while,
    flat.Break: Runner.leave_loop,
    flat.Return: Runner.leave_function,
    flat.Assert: Runner.check,
    flat.WhenStatement: Runner.refuse,
    flat.Terminate: Runner.refuse,
    flat.Reinit: Runner.refuse,
}


def _unwritten(variable: flat.Variable, dims: flat.Dims) -> flat.Dims:
    """The dimensions before any assignment: those written `:` are zero."""
    written = (*variable.sizes, *(None,) * len(dims))
    return tuple(
        0 if n is None and size is None else n for n, size in zip(dims, written, strict=False)
    )


def _bound(entries: float, variable: flat.Variable) -> None:
    if not 0 <= entries <= MAX_ENTRIES:
        message = f"`{variable.name}` cannot have {entries:g} entries"
        raise error("L323", message, variable.span)


_KNOWN = (flat.Literal, flat.Unary, flat.Binary)


def _never_ends(loop: flat.WhileStatement) -> str | None:
    """The hint about a loop that changes nothing of its condition."""
    if all(isinstance(e, _KNOWN) for e in nodes_of([loop.condition])):
        written = loop.condition.span.text
        return f"`{written}` holds for ever: let the condition ask for what the loop changes"
    asked = dict.fromkeys(
        e.name for e in nodes_of([loop.condition]) if isinstance(e, flat.Reference)
    )
    changed = assigned_in(loop.body)  # records by their fields
    changed += [name.partition(".")[0] for name in changed]
    if not asked or not {*asked}.isdisjoint(changed):
        return None
    return f"nothing in the loop changes {both(asked)}, by which it ends"
