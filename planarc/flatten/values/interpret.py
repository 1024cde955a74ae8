"""Running a function while compiling, when all its arguments are constants.

In:   flat.Function, argument values
Out:  the values of its results

Reference: Modelica Language Specification 3.6, sections 11.2 and 12.4.4.
"""

from __future__ import annotations

from contextlib import suppress
from typing import Any, Protocol

from planarc.core.diagnostic import Diagnostic, Misfit, error
from planarc.core.prose import counted, sized
from planarc.core.source import Span
from planarc.flatten.terms.constant import Frame, NotConstant, Value
from planarc.flatten.tree.nodes import Session
from planarc.flatten.values import compute
from planarc.flatten.values.foreign import external_values
from planarc.ir import flat

MAX_STEPS = 2_000_000
MAX_CALLS = 200  # functions inside functions


class Caller(Protocol):
    """The evaluator that meets a call."""

    session: Session | None
    depth: int

    def value(self, e: flat.Expression, /) -> Value: ...

    def called(self, frame: Frame, /) -> Caller: ...

    def function(self, name: str, /) -> flat.Function | None: ...


class _Leave(Exception):
    """`break` or `return`."""

    def __init__(self, whole: bool) -> None:
        self.whole = whole


class _Run:
    """One call: the variables and a share of the steps."""

    def __init__(self, function: flat.Function, caller: Caller) -> None:
        self.function = function
        self.frame: Frame = {}
        self.sizes: dict[str, flat.Dims] = {}  # as they are declared
        self.evaluator = caller.called(self.frame)
        self.value = self.evaluator.value
        self.steps = 0

    def declare(self, variable: flat.Variable) -> None:
        self.sizes[variable.name] = dims = self._dims(variable)
        if variable.binding is not None:
            value = self.value(variable.binding)
            _expect_size(variable.name, dims, value, variable.binding.span)
            self.frame[variable.name] = value
        elif dims or variable.type.base is flat.Base.RECORD:
            # Entries and fields may be assigned one by one.
            self.frame[variable.name] = _empty(variable.type, dims)
        else:
            self.frame[variable.name] = None

    def _dims(self, variable: flat.Variable) -> flat.Dims:
        """The dimensions, with those that depend on the inputs computed."""
        dims: list[int | None] = []
        for k, size in enumerate(variable.type.dims):
            expression = variable.sizes[k] if k < len(variable.sizes) else None
            known = self.value(expression) if expression is not None else size
            dims.append(known if isinstance(known, int) else None)
        return tuple(dims)

    def external(self, span: Span) -> list[Value]:
        """The outputs of an external function."""
        session = self.evaluator.session
        assert session is not None
        given = [self.value(e) for e in self.function.given]
        empty = {v.name: _empty(v.type, self._dims(v)) for v in self.function.outputs}
        found = external_values(self.function, given, empty, session, span)
        return [found[v.name] for v in self.function.outputs]

    def run(self, statements: tuple[flat.Statement, ...]) -> None:
        for statement in statements:
            self.steps += 1
            if self.steps > MAX_STEPS:
                raise NotConstant(f"`{self.function.name}` takes too many steps", statement.span)
            self.step(statement)

    def step(self, statement: flat.Statement) -> None:
        match statement:
            case flat.Assignment(target=target, value=value):
                self.assign(target, self.value(value))
            case flat.TupleAssignment(targets=targets, value=call):
                self._assign_results(targets, call)
            case flat.IfStatement(branches=branches, otherwise=otherwise):
                bodies = (body for condition, body in branches if self.value(condition))
                self.run(next(bodies, otherwise))
            case flat.ForStatement():
                self._loop(statement)
            case flat.WhileStatement(condition=condition, body=body):
                while self.value(condition):
                    if self._turn(body):
                        break
            case flat.Break():
                raise _Leave(whole=False)
            case flat.Return():
                raise _Leave(whole=True)
            case flat.Assert(condition=condition, message=message, warning=warning):
                if not self.value(condition) and not warning:
                    raise error("F288", f"assertion failed: {self.value(message)}", statement.span)
            case _:
                raise NotConstant("this statement cannot be run before the run", statement.span)

    def _loop(self, statement: flat.ForStatement) -> None:
        values = self.value(statement.range)
        assert isinstance(values, list)
        hidden = self.frame.get(statement.iterator)
        for value in values:
            self.frame[statement.iterator] = value
            if self._turn(statement.body):
                break
        self.frame.pop(statement.iterator, None)
        if hidden is not None:
            self.frame[statement.iterator] = hidden

    def _turn(self, body: tuple[flat.Statement, ...]) -> bool:
        """One turn of a loop; True when it was left."""
        self.steps += 1
        try:
            self.run(body)
        except _Leave as leave:
            if leave.whole:
                raise
            return True
        return False

    def _assign_results(self, targets: tuple[flat.Target | None, ...], call: flat.Call) -> None:
        inner = self.evaluator.function(call.function)
        if inner is None:
            raise NotConstant(f"`{call.function}` is not known", call.span)
        arguments = [self.value(a) for a in call.arguments]
        results = run_function(inner, arguments, self.evaluator, call.span)
        for target, value in zip(targets, results, strict=False):
            if target is not None:
                self.assign(target, value)

    def assign(self, target: flat.Target, value: Value) -> None:
        if not isinstance(target, flat.Reference):
            raise NotConstant("variables of a model have no value before the run", target.span)
        name, *fields = target.name.split(".") if target.name not in self.frame else [target.name]
        wanted = target.type.dims
        if not target.subscripts:
            wanted = self.sizes.get(target.name, wanted)
        if not any(isinstance(s, flat.Slice) or s.type.dims for s in target.subscripts):
            _expect_size(target.span.text, wanted, value, target.span)
        indices = [None if isinstance(s, flat.Slice) else self.value(s) for s in target.subscripts]
        old = self.frame.get(name)
        old = 0.0 if old is None else old
        self.frame[name] = _stored_field(old, fields, indices, value, target.span)


def _expect_size(name: str, wanted: flat.Dims, value: Value, span: Span) -> None:
    """Refuse an array of other sizes than a variable is declared with."""
    shape = compute.shape(value)  # of an array without entries not all of it
    if any(w and w != n for w, n in zip(wanted, shape, strict=False)):  # 0 if its size is set later
        message = f"`{name}` has {sized([wanted])}, its value {sized([shape])}"
        raise Misfit(Diagnostic("F270", message, span))


def _empty(type_: flat.Type, dims: flat.Dims) -> Value:
    """What a variable is before it is assigned; dimensions written `:` are zero."""
    return compute.fill(_default(type_), *(n or 0 for n in dims)) if dims else _default(type_)


def _default(type_: flat.Type) -> Value:
    if type_.base is flat.Base.RECORD:
        return {n: compute.fill(_default(t), *[d or 0 for d in t.dims]) for n, t in type_.fields}
    return _DEFAULTS[type_.base]


_DEFAULTS: dict[flat.Base, Value] = {
    flat.Base.REAL: 0.0,
    flat.Base.INTEGER: 0,
    flat.Base.BOOLEAN: False,
    flat.Base.STRING: "",
    flat.Base.ENUMERATION: 1,
    flat.Base.FUNCTION: 1,
}


def _stored_field(
    old: Value, fields: list[str], indices: list[Value | None], value: Value, span: Span
) -> Value:
    """`old` with the field (of the entry at the first indices) replaced."""
    if not fields:
        return _stored(old, indices, value, span)
    if isinstance(old, dict):
        inner = _stored_field(old.get(fields[0], 0.0), fields[1:], indices, value, span)
        return {**old, fields[0]: inner}
    first = indices[0] if indices else None
    if not isinstance(old, list) or not isinstance(first, int):
        raise NotConstant("fields of several records are assigned at once", span)
    entry = _stored_field(compute.entry(old, first, span), fields, indices[1:], value, span)
    return [*old[: first - 1], entry, *old[first:]]


def _stored(old: Value, indices: list[Any], value: Value, span: Span) -> Value:
    """`old` with the entry at the indices replaced."""
    if not indices:
        return value
    if not isinstance(old, list):
        raise error("F218", "too many subscripts", span)
    new = list(old)
    first, rest = indices[0], indices[1:]
    if first is None or isinstance(first, list):
        places = range(1, len(old) + 1) if first is None else first
        if isinstance(value, list) and len(value) != len(places):
            message = f"{counted(len(value), 'value')} cannot be assigned to {len(places)} places"
            raise error("F270", message, span)
        for k, place in enumerate(places):
            entry = value[k] if isinstance(value, list) else value
            new[int(place) - 1] = _stored(compute.entry(old, place, span), rest, entry, span)
        return new
    new[int(first) - 1] = _stored(compute.entry(old, first, span), rest, value, span)
    return new


def run_function(
    function: flat.Function, arguments: list[Value], caller: Caller, span: Span
) -> list[Value]:
    """The results of a call with known arguments."""
    if caller.depth >= MAX_CALLS:
        raise NotConstant(f"`{function.name}` calls itself too often", span)
    if function.derivative_of is not None:
        raise NotConstant(f"`{function.name}` is a derivative", span)
    run = _Run(function, caller)
    for variable, value in zip(function.inputs, arguments, strict=True):
        run.frame[variable.name] = value
    if function.external and compute.is_known(function.external):
        call = flat.Builtin(function.outputs[0].type, span, function.external)
        return [compute.apply(arguments, call)]
    if function.external is not None:
        return run.external(span)
    try:
        for variable in (*function.locals, *function.outputs):
            run.declare(variable)
        with suppress(_Leave):
            run.run(function.body)
    except Misfit as problem:
        raise problem.called(span) from None
    results = []
    for variable in function.outputs:
        result = run.frame[variable.name]
        if result is None:
            reason = f"`{function.name}` gives its output `{variable.name}` no value"
            raise NotConstant(reason, span)
        results.append(result)
    return results
