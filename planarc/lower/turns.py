"""Loops whose end is known only while the model runs, as one operation (`ir.loop`).

In:   a Runner before the loop
Out:  the same behind it: what turns assign has the values behind the last one

A turn is run once, on symbols in the place of what turns assign. Where a variable may have no
value yet, a flag goes with it from turn to turn; so does one with each assertion of a turn, and
what its message tells. `break`, `return` and assertions that fail leave the loop by a flag.

Example: `while abs(d) > 1e-9 loop s := s + d; d := d*x; end while;` is run on s' and d', which
gives s' + d' and d'*x.

Promises:  what comes behind sees no symbol of a turn; a loop without end ends the run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, TypeAlias

from msgspec.structs import replace

from planarc.ir import dae, flat
from planarc.ir.closing import close
from planarc.ir.expr import Expr, below
from planarc.ir.flatwalk import assigned_in
from planarc.ir.loop import LOST, MOST_TURNS
from planarc.lower.assignment import zero_of
from planarc.lower.scope import unsupported
from planarc.lower.statements import LEFT, RETURNED, Header, Runner
from planarc.lower.unset import Unset
from planarc.lower.values import RecordValue, Value, expr
from planarc.runtime.tensor import Tensor, each

#: Of a message: a text, or a value and how it is written.
Part: TypeAlias = "str | tuple[Expr, str]"


def run_loop(runner: Runner, header: Header) -> None:
    """Run a loop. Raises PlanarcError where a turn cannot be run once for all."""
    turn = _Turn(runner, header)
    model = runner.scope.model
    count = len(model.assertions)
    with model.in_turn(header.loop.span):
        holds = header.holds(turn.inner)
        asked = len(model.assertions) > count
        turn.inner.run_body(header.loop.body)
        header.step(turn.inner)
    turn.close(holds, model.take_assertions(count))
    if asked:  # what was asserted of the condition holds behind the last turn, too
        path, runner.path = runner.path, runner.on_path(turn.not_left())
        header.holds(runner)
        runner.path = path
    returned = turn.returned()
    if returned is not runner.scope.table.false:
        runner.split(returned).end()


class _Turn:
    """A turn, from what it begins with to what it leaves behind."""

    def __init__(self, outer: Runner, header: Header) -> None:
        self._outer, self._loop, self._table = outer, header.loop, outer.scope.table
        self._first: dict[Expr, Expr] = {}  # what each symbol is before the first turn
        self._next: dict[Expr, Expr] = {}  # and before the next one
        self._behind: dict[Expr, Expr] = {}  # and behind the last one
        self._kept: dict[str, Value] = {}  # variables, in symbols
        self._flags: dict[str, Expr] = {}  # of those that may have no value
        self._left = self._returned = self._table.false
        for name in (*self._assigned(), *filter(None, [header.counted])):
            self._begin(name)
        truths = {LEFT: self._table.false, RETURNED: self._table.false}
        self.inner: Runner = replace(
            outer, scope=replace(outer.scope, path=None), path=None, events=False,
            frames=[], forks=[], values={**outer.values, **self._kept, **truths},
            unset=Unset({**outer.unset.conditions, **self._flags}),
        )  # fmt: skip

    def _assigned(self) -> dict[str, None]:
        """The variables that turns assign, whole."""
        known = self._outer.sizes.keys() | self._outer.values.keys()
        names = assigned_in((self._loop,))
        return dict.fromkeys(n if n in known else n.partition(".")[0] for n in names)

    def _carry(self, first: Expr) -> Expr:
        model = self._outer.scope.model
        model.symbols_of_turns += 1
        symbol = self._table.symbol(f"$carried{model.symbols_of_turns}")
        self._first[symbol] = first
        return symbol

    def _begin(self, name: str) -> None:
        """Let a turn begin with what the one before has left in a variable."""
        outer = self._outer
        unset = outer.unset.conditions.get(name)
        value = outer.values.get(name)
        if value is None:
            value, unset = self._zero(name), self._table.true
        self._kept[name] = self._mapped(value, self._carry)
        if unset is not None:
            self._flags[name] = self._carry(unset)

    def _zero(self, name: str) -> Value:
        """The place of a variable that has no value before the loop."""
        function = self._outer.function
        assert function is not None, f"`{name}` has a value in a model"
        type_ = next(v.type for v in (*function.outputs, *function.locals) if v.name == name)
        sized = type_.with_dims(self._outer.sizes.get(name, type_.dims))
        if None in sized.dims:
            raise unsupported(f"a size of `{name}` that is set in a loop", self._loop.span)
        return zero_of(sized, self._table)

    def _mapped(self, value: Value, of: Callable[[Expr], Expr]) -> Value:
        """A value with other numbers."""

        def mapped(v: Value) -> Value:
            if isinstance(v, RecordValue):
                return RecordValue(tuple((n, self._mapped(f, of)) for n, f in v.fields))
            if not isinstance(v, Expr):
                raise unsupported("a text that a loop changes while running", self._loop.span)
            return of(v)

        return each(mapped, value)

    # After it

    def close(self, holds: Expr, asserted: Sequence[dae.Assertion]) -> None:
        """Put what the last turn leaves behind into the values outside."""
        t, inner, outer = self._table, self.inner, self._outer
        for name, kept in self._kept.items():
            self._follow(name, kept, inner.values.get(name))
            if name in self._flags:
                self._next[self._flags[name]] = inner.unset.conditions.get(name, t.false)
        told = [(a, *self._watch(a)) for a in asserted]
        left = t.or_(self._truth(LEFT), self._truth(RETURNED))
        for a in asserted:
            left = left if a.warning else t.or_(left, t.not_(a.condition))
        self._left, self._returned = self._flag(left), self._flag(self._truth(RETURNED))
        goes_on = t.and_(t.not_(self._left), holds)
        path = outer.whole_path()
        self._compute(goes_on if path is None else t.and_(path, goes_on))
        found = outer.scope.model.assertions
        found += [replace(a, condition=self._after(ok), message=self._message(parts))
                  for a, ok, parts in told]  # fmt: skip
        for name, kept in self._kept.items():
            outer.values[name] = self._mapped(kept, self._after)
        flags = {n: self._after(f) for n, f in self._flags.items()}
        outer.unset = Unset({**outer.unset.conditions, **flags}, outer.unset.over)

    def _flag(self, following: Expr) -> Expr:
        """A truth that goes from turn to turn, where it may become true."""
        if following is self._table.false:
            return following
        flag = self._carry(self._table.false)
        self._next[flag] = following
        return flag

    def _truth(self, name: str) -> Expr:
        return expr(self.inner.values[name])

    def _follow(self, name: str, kept: Value, found: Value | None) -> None:
        """What is left in a variable is what the next turn begins with."""
        if found is None or structure_of(found) != structure_of(kept):
            raise unsupported(f"a size of `{name}` that a loop changes", self._loop.span)
        self._next |= zip(leaves(kept), leaves(found), strict=True)

    def _watch(self, a: dae.Assertion) -> tuple[Expr, tuple[Part, ...]]:
        """Whether an assertion has held so far, and what it tells if not."""
        t, ok = self._table, self._carry(self._table.true)
        self._next[ok] = t.and_(ok, a.condition)

        def kept(part: Part) -> Part:
            if isinstance(part, str) or self._first.keys().isdisjoint(below((part[0],))):
                return part
            told = self._carry(t.zero)
            self._next[told] = t.if_(ok, part[0], told)
            return told, part[1]

        return ok, tuple(map(kept, a.message.parts))

    def _message(self, parts: Sequence[Part]) -> dae.Message:
        return dae.Message(
            tuple(p if isinstance(p, str) else (self._after(p[0]), p[1]) for p in parts)
        )

    def _compute(self, goes_on: Expr) -> None:
        """The values behind the loop, which must end."""
        t, outer = self._table, self._outer
        name = outer.function.name if outer.function is not None else "algorithm"
        carried = tuple(self._first)
        following = [self._next[symbol] for symbol in carried]
        loop, given = close(name, carried, goes_on, following)
        arguments = (*self._first.values(), *given)
        for i, symbol in enumerate(carried):
            self._behind[symbol] = t.loop(loop, i, arguments)
        ended, what = t.loop(loop, loop.ended, arguments), f"`{self._written()}` in {outer.label}"
        for condition, message in (
            (t.not_(t.equal(ended, t.const(LOST))), f"{what} hangs on what is not a number"),
            (t.not_(t.equal(ended, t.zero)), f"{what} does not end within {MOST_TURNS} turns"),
        ):
            found = dae.Assertion(condition, dae.Message((message,)), span=self._loop.span)
            outer.scope.model.assertions.append(found)

    def _written(self) -> str:
        s = self._loop
        if isinstance(s, flat.WhileStatement):
            return f"while {s.condition.span.text}"
        return f"for {s.iterator} in {s.range.span.text}"

    def _after(self, e: Expr) -> Expr:
        return self._behind.get(e, e)

    def not_left(self) -> Expr:
        """Where the condition has ended the loop."""
        return self._table.not_(self._after(self._left))

    def returned(self) -> Expr:
        """Where `return` has."""
        return self._after(self._returned)


def structure_of(value: Value) -> Any:
    """What values that follow each other have in common."""
    if isinstance(value, RecordValue):
        return tuple((n, structure_of(v)) for n, v in value.fields)
    if isinstance(value, Tensor):
        return value.shape, tuple(map(structure_of, value.items[:1]))
    return isinstance(value, Expr)


def leaves(value: Value) -> Iterator[Expr]:
    """The numbers of a value, in their order."""
    if isinstance(value, RecordValue):
        value = Tensor((len(value.fields),), tuple(v for _, v in value.fields))
    if isinstance(value, Tensor):
        for item in value.items:
            yield from leaves(item)
    else:
        yield expr(value)
