"""Calls of the model's functions, put in place by running the function on expressions.

In:   flat.Function and the values of its inputs
Out:  the values of its outputs, as expressions of the inputs

Example:

    function resolve1                      resolve1(phi, {x, y})
      input Real phi; input Real v[2];     ->  {cos(phi)*x - sin(phi)*y,
      output Real w[2];                         sin(phi)*x + cos(phi)*y}
    algorithm
      w := {{cos(phi), -sin(phi)}, {sin(phi), cos(phi)}}*v;

An `if` whose condition is not known is run on both sides and joined; loops run
as often as they would, which must be known when the model is compiled; where it hangs on
an Integer that chooses an array's entry, each entry is a case of its own.

Promises:  no call is left; what cannot be run so is refused with the function's name.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.diagnostic import Diagnostic, Misfit, PlanarcError, Related, error
from planarc.core.prose import sized
from planarc.core.source import Span
from planarc.ir import flat
from planarc.ir.calculus import partial
from planarc.ir.expr import Expr, Substitution
from planarc.ir.flatwalk import expressions_of_function, names_in, nodes_of, with_sources
from planarc.lower import scalar
from planarc.lower.scope import Endless, OutsideArray, Scope, UnknownCourse
from planarc.lower.statements import Roll, Runner
from planarc.lower.values import FunctionValue, RecordValue, Value, conform, expr
from planarc.runtime import elementary
from planarc.runtime.tensor import Tensor, each, shape_of

MAX_DEPTH = 100  # of calls inside calls


class TooDeep(PlanarcError):
    """A recursion does not end for what is known of its arguments (L320)."""

    def __init__(self, found: Diagnostic) -> None:
        super().__init__(found)
        self.calls: list[_Call] = []  # that it has ended, the innermost first


class _Call(Data):
    function: flat.Function
    arguments: Sequence[Value]
    span: Span


def inline(scope: Scope, name: str, arguments: Sequence[Value], span: Span) -> tuple[Value, ...]:
    """The results of a call. Raises PlanarcError when it cannot be run on expressions."""
    if scope.depth >= MAX_DEPTH:
        raise TooDeep(_endless(name, span))
    passed = scope.locals.get(name) if scope.locals else None
    if isinstance(passed, FunctionValue):  # a functional argument is called
        bound = dict(passed.bound)
        function = scope.model.functions[passed.function]
        given = iter(arguments)
        arguments = [
            bound[v.name] if v.name in bound else _next_or_default(scope, given, v)
            for v in function.inputs
        ]
        scope, name = _deeper(scope), passed.function  # which may be called as the argument is
    function = scope.model.functions[name]
    call = _Call(function, arguments, span)
    if function.external is not None and function.external in elementary.TABLE:
        name = function.external
        return (each(lambda *a: scope.table.call(name, *a), *arguments),)
    if function.external is not None:
        from planarc.lower.foreign import call_external

        return call_external(_started(_deeper(scope), call), function, span)
    if function.derivative_of is not None:
        return _derivative(scope, call)
    found = _run(_deeper(scope), call)
    if not function.derivatives:
        return found
    from planarc.lower.rates import with_rates

    return with_rates(scope, function, arguments, found, span)


def _run(scope: Scope, call: _Call) -> tuple[Value, ...]:
    """The results in the first way that succeeds: with what is known of the arguments, with the
    values of parameters, for each entry that they may choose, with loops that stay loops."""
    key = (call.function.name, *call.arguments)  # a function of three outputs is called thrice
    refused = scope.model.refused
    refusal = refused.get(key) or _refused_alike(scope, call)
    if refusal is None:
        try:
            return _results(scope, call)
        except TooDeep as problem:
            problem.calls.append(call)
            if scope.depth > 1:  # the model's own call decides what else is tried
                raise
            refusal = _told_at(call, problem)
        except RecursionError:
            if scope.depth > 1:
                raise
            message = f"what `{call.function.name}` computes is nested too deeply"
            hint = "split its expressions, or write a loop in the place of a recursion"
            refusal = UnknownCourse(Diagnostic("L300", message, call.span, hint=hint))
        except OutsideArray as problem:
            return _by_loops(scope, call, problem)  # nothing says that a search goes so far
        except Endless as problem:
            refusal = problem.with_traceback(None)
            refused[_pattern(call)] = refusal
        except UnknownCourse as problem:
            refusal = problem.with_traceback(None)
        refused[key] = refusal
    # Its course depends on parameters in too many ways: their values become structural.
    frozen = set(scope.model.frozen)
    known = replace(call, arguments=[_number(scope, a) for a in call.arguments])
    if known.arguments != list(call.arguments):
        with suppress(UnknownCourse, TooDeep):
            return _results(scope, known)
    if found := _by_cases(scope, known):
        return found
    scope.model.frozen = frozen
    return _by_loops(scope, call, refusal)


def _refused_alike(scope: Scope, call: _Call) -> UnknownCourse | None:
    """The refusal of a call of which as much is known: nothing told when a loop in it ends."""
    found = scope.model.refused.get(_pattern(call))
    if found is None:
        return None
    return UnknownCourse(
        replace(found.diagnostics[0], related=(Related("called here", call.span),))
    )


def _pattern(call: _Call) -> tuple[object, ...]:
    """What is known of a call."""
    return "", call.function.name, *(a if _is_known(a) else shape_of(a) for a in call.arguments)


def _is_known(value: Value) -> bool:
    if isinstance(value, RecordValue):
        return all(_is_known(v) for _, v in value.fields)
    if isinstance(value, Tensor):
        return all(map(_is_known, value.items))
    return value.is_const if isinstance(value, Expr) else True


def _by_loops(
    scope: Scope, call: _Call, refusal: UnknownCourse | OutsideArray
) -> tuple[Value, ...]:
    """The results with loops that stay loops. Raises the refusal where these are not the reason
    that there are none."""
    if refusal.diagnostics[0].code in ("L300", "L320"):
        raise refusal
    from planarc.lower.turns import run_loop

    try:
        return _results(scope, call, run_loop)
    except RecursionError:
        raise refusal from None
    except PlanarcError as problem:
        if isinstance(refusal, UnknownCourse):
            raise refusal.nor(problem) from None
        raise refusal from None


def _told_at(call: _Call, problem: TooDeep) -> UnknownCourse:
    """The refusal of a recursion without end, with the call that begins it."""
    names = [c.function.name for c in problem.calls]  # the innermost first, which may be no part
    last = next((c for k, c in enumerate(problem.calls) if names[k] in names[k + 1 :]), call)
    related = (Related("called here", call.span),)
    return UnknownCourse(replace(_endless(last.function.name, last.span), related=related))


def _endless(name: str, span: Span) -> Diagnostic:
    message = f"`{name}` calls itself more than {MAX_DEPTH} times"
    hint = "let its end depend on arguments that are known before the run, or write a loop"
    return Diagnostic("L320", message, span, hint=hint)


def _by_cases(scope: Scope, call: _Call) -> tuple[Value, ...]:
    """A choice among the results for each entry that an Integer input may mean.

    Nothing, where no input is one, or no entry gives results.
    """
    arguments = call.arguments
    entries = max((a.shape[0] for a in arguments if isinstance(a, Tensor) and a.shape), default=0)
    unknown = [i for i in places(call.function) if not expr(arguments[i]).is_const]
    if not unknown:
        return ()
    at, numbers = expr(arguments[unknown[0]]), list(arguments)
    found: tuple[Value, ...] = ()
    fit: list[int] = []
    for number in range(entries, -1, -1):  # a range up to zero is empty
        numbers[unknown[0]] = place = scope.table.const(number)
        here = scope.table.equal(at, place)
        with suppress(OutsideArray, Misfit):  # from here it would go on beyond the last entry
            case = _results(scope.where(here), replace(call, arguments=numbers))
            found = tuple(
                scalar.choose(scope, here, new, old, call.span)
                for new, old in zip(case, found or case, strict=True)
            )
            fit.append(number)
    if fit:
        scope.keep_within(at, fit, call.span)
    return found


def _number(scope: Scope, value: Value) -> Value:
    if isinstance(value, RecordValue):
        return RecordValue(tuple((n, _number(scope, v)) for n, v in value.fields))
    if isinstance(value, Tensor):
        return Tensor(value.shape, tuple(_number(scope, v) for v in value.items))
    return scope.model.number(value) if isinstance(value, Expr) else value


def _deeper(scope: Scope) -> Scope:
    return replace(scope, depth=scope.depth + 1)


def _next_or_default(scope: Scope, given: Iterator[Value], variable: flat.Variable) -> Value:
    value = next(given, None)
    if value is not None:
        return value
    assert variable.binding is not None, f"the flat model passes no `{variable.name}`"
    return scalar.lower_expression(scope, variable.binding)


def _derivative(scope: Scope, call: _Call) -> tuple[Value, ...]:
    """`function f_s = der(f, s)` (12.7.2): run f on stand-ins, differentiate, put values in."""
    assert call.function.derivative_of is not None
    table = scope.table
    original, names = call.function.derivative_of
    stand_ins: dict[Expr, Expr] = {}

    def stand_in(value: Value) -> Expr:
        symbol = table.symbol(f"$argument{len(stand_ins)}_{scope.depth}")
        stand_ins[symbol] = expr(value)
        return symbol

    parameters = scope.model.functions[original].inputs if original in scope.model.functions else ()
    pairs = zip(parameters, call.arguments, strict=True)
    given = [stand_in(a) if p.name in names else a for p, a in pairs]
    count = len(scope.model.assertions)
    results: tuple[Value, ...] = inline(_deeper(scope), original, given, call.span)
    scope.model.take_assertions(count)  # of the stand-ins; the function itself is called, too
    for name in names:
        position = next(i for i, p in enumerate(parameters) if p.name == name)
        by = partial(table, expr(given[position]))
        results = tuple(each(by, r) for r in results)
    put_in = Substitution(table, stand_ins)
    return tuple(each(put_in, r) for r in results)


def _results(scope: Scope, call: _Call, roll: Roll | None = None) -> tuple[Value, ...]:
    function, runner = call.function, _started(scope, call, roll)
    for variable in function.inputs:
        _refuse_argument(runner, variable, call)
    asserted, count = scope.model.assertions, len(scope.model.assertions)
    with scope.model.undone_on_error():
        try:
            for variable in _in_turn(function):
                runner.declare(variable)
            runner.run_body(function.body)
        except Misfit as problem:
            raise problem.called(call.span) from None
        except OutsideArray as problem:
            raise runner.outside(problem) from None
    asserted[count:] = [scope.model.called(a, call.span) for a in asserted[count:]]
    missing = [v.name for v in function.outputs if v.name not in runner.values]
    if missing:
        message = f"function `{function.name}` gives its output `{missing[0]}` no value"
        related = (Related("the function", function.span),)
        raise UnknownCourse(Diagnostic("L321", message, call.span, related=related))
    for variable in function.outputs:
        if variable.name in runner.unset.conditions:
            message = f"`{function.name}` gives its output `{variable.name}` no value"
            runner.here().keep_set(variable.name, message, variable.span)
    return tuple(runner.values[v.name] for v in function.outputs)


def _in_turn(function: flat.Function) -> Sequence[flat.Variable]:
    """Outputs and locals; outputs whose sizes are written with locals come behind these."""
    names = {v.name for v in function.locals}
    late = [v.name for v in function.outputs if names & names_in(filter(None, v.sizes))]
    if not late:
        return (*function.outputs, *function.locals)
    early = (v for v in function.outputs if v.name not in late)
    return (*early, *function.locals, *(v for v in function.outputs if v.name in late))


def _refuse_argument(runner: Runner, variable: flat.Variable, call: _Call) -> None:
    """Refuse an array of other sizes than the other arguments say (12.4.1)."""
    value = runner.values[variable.name]
    sizes = [size for size in variable.sizes if size is not None]
    if not sizes or not isinstance(value, Tensor) or not names_in(sizes) <= runner.values.keys():
        return
    wanted = runner.dims(variable)
    if not conform(wanted, value.shape):
        what = f"the input `{variable.name}` of `{call.function.name}`"
        message = f"{what} must have {sized([wanted])}, but has {sized([value.shape])}"
        raise error("L331", message, call.span, related=(Related("the input", variable.span),))


def _started(scope: Scope, call: _Call, roll: Roll | None = None) -> Runner:
    function = call.function
    values = dict(zip((v.name for v in function.inputs), call.arguments, strict=True))
    label = f"function `{function.name}`"
    return Runner(scope, label, call.span, values=values, function=function, roll=roll)


# Integers that choose an entry --------------------------------------------------------


def places(function: flat.Function) -> list[int]:
    """The inputs that say which entry of an array is meant, such as where a search begins:

        next := last;
        while next < n and u >= table[next, 1] loop  next := next + 1;  end while;

    One is an Integer that stands in a subscript, or in what a variable is assigned that stands
    in one; the function can be run once for each entry that it may mean.
    """
    names = with_sources(_subscripts(function), function.body)
    return [
        i
        for i, v in enumerate(function.inputs)
        if v.name in names and v.type.base is flat.Base.INTEGER and not v.type.dims
    ]


def _subscripts(function: flat.Function) -> set[str]:
    """The variables in subscripts."""
    found: set[str] = set()
    for node in nodes_of(expressions_of_function(function)):
        if isinstance(node, flat.Reference | flat.Index):
            found |= names_in(node.subscripts)
    return found
