"""Small models written as text, and a plain evaluator of sorted models."""

from __future__ import annotations

import ast
import importlib.util
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from planarc.core.source import Source, Span
from planarc.evaluate.value import evaluate
from planarc.ir.dae import Dae, Equation, Kind, Parameter, Relation, Variable
from planarc.ir.expr import Expr, Exprs, Op
from planarc.ir.flat import StateSelect
from planarc.ir.sorted import Assignment, Block, SortedDae
from planarc.runtime.elementary import TABLE
from planarc.structure.pipeline import structure
from tests.ir.check.sorted import check_sorted


def read_text(table: Exprs, source: str) -> Expr:
    """`der(a.b) + r[1]^2` as an expression; `==`, `<`, `and`, `x if c else y` as in Python."""
    return _read(table, ast.parse(source.strip().replace("^", "**"), mode="eval").body)


def _name(node: ast.expr) -> str:
    return ast.unparse(node).replace(" ", "")


def _read(t: Exprs, n: ast.expr) -> Expr:
    match n:
        case ast.Constant(value):
            return t.const(value)
        case ast.Name("time"):
            return t.time
        case ast.Name() | ast.Attribute():
            return t.symbol(_name(n))
        case ast.Subscript(ast.Name("event"), ast.Constant(i)):
            return t.event(i)
        case ast.Subscript():
            return t.symbol(_name(n))
        case ast.UnaryOp(ast.USub(), a):
            return t.neg(_read(t, a))
        case ast.UnaryOp(ast.Not(), a):
            return t.not_(_read(t, a))
        case ast.BinOp(a, op, b):
            x, y = _read(t, a), _read(t, b)
            match op:
                case ast.Add():
                    return t.add(x, y)
                case ast.Sub():
                    return t.sub(x, y)
                case ast.Mult():
                    return t.mul(x, y)
                case ast.Div():
                    return t.div(x, y)
                case ast.Pow():
                    return t.pow(x, y)
        case ast.BoolOp(op, values):
            found = [_read(t, v) for v in values]
            make = t.and_ if isinstance(op, ast.And) else t.or_
            result = found[0]
            for v in found[1:]:
                result = make(result, v)
            return result
        case ast.IfExp(c, a, b):
            return t.if_(_read(t, c), _read(t, a), _read(t, b))
        case ast.Compare(a, [op], [b]):
            x, y = _read(t, a), _read(t, b)
            if isinstance(op, ast.Gt | ast.GtE):
                x, y = y, x
            return t.less(x, y) if isinstance(op, ast.Lt | ast.Gt) else t.less_equal(x, y)
        case ast.Call(ast.Name("der"), [a]):
            return t.der(_read(t, a))
        case ast.Call(ast.Name("pre"), [a]):
            return t.pre(_name(a))
        case ast.Call(ast.Name(f), args) if f in TABLE:
            return t.call(f, *(_read(t, a) for a in args))
    raise AssertionError(ast.dump(n))


@pytest.fixture(scope="session")
def read() -> Callable[[Exprs, str], Expr]:
    return read_text


Options = Mapping[str, Any]
Maker = Callable[..., Dae]


@pytest.fixture(scope="session")
def make() -> Maker:
    """`make("der(x) = -a*x", "y = x", a=2, x={"start": 1})`: every equation is its own line.

    Names with a number are parameters, others variables with attributes; `variables`
    not named so are in the order of their first use.
    """
    return make_dae


def make_dae(
    *equations: str,
    table: Exprs | None = None,
    initial: Sequence[str] = (),
    discrete: Mapping[str, str] | None = None,
    inputs: Sequence[str] = (),
    attributes: Mapping[str, Options] | None = None,
    relations: Sequence[str] = (),
    minima: Mapping[str, float] | None = None,
    **parameters: float,
) -> Dae:
    t = table or Exprs()
    source = Source("model.pmo", "\n".join((*equations, *initial, *(discrete or {}).values())))
    start = 0
    made = []
    for line in (*equations, *initial):
        left, right = line.split(" = ")
        span = Span(source, start, start + len(line))
        start += len(line) + 1
        made.append(Equation(read_text(t, left), read_text(t, right), span))
    count = len(equations)
    names: dict[str, None] = {}
    for e in t.all:
        if e.op is Op.SYMBOL:
            names.setdefault(e.name)
    known = {*parameters, *inputs, *(discrete or {})}
    variables = tuple(
        _variable(t, name, (attributes or {}).get(name, {})) for name in names if name not in known
    )
    equations_of_discrete = tuple(
        Equation(t.symbol(name), read_text(t, value), Span(source, 0, 1))
        for name, value in (discrete or {}).items()
        if value
    )
    return Dae(
        name="Test",
        table=t,
        variables=variables,
        parameters=tuple(
            Parameter(
                name,
                Kind.REAL,
                t.const(value),
                settable=True,
                minimum=t.const(minima[name]) if minima and name in minima else None,
            )
            for name, value in parameters.items()
        ),
        equations=tuple(made[:count]),
        initial_equations=tuple(made[count:]),
        discretes=tuple(Variable(name, Kind.BOOLEAN) for name in discrete or {}),
        discrete_equations=equations_of_discrete,
        inputs=tuple(Variable(name) for name in inputs),
        relations=tuple(Relation(read_text(t, r), True, False, f"{r} < 0") for r in relations),
    )


def _variable(t: Exprs, name: str, options: Options) -> Variable:
    v = Variable(name)
    for key, value in options.items():
        if key == "start":
            v = replace(v, start=read_text(t, str(value)), start_written=True)
        elif key == "select":
            v = replace(v, state_select=StateSelect[value.upper()])
        else:
            v = replace(v, **{key: value})
    return v


@pytest.fixture(scope="session")
def sort() -> Callable[..., SortedDae]:
    """Like `make`, but structured and checked."""
    return sort_text


def sort_text(*equations: str, **options: Any) -> SortedDae:
    model = structure(make_dae(*equations, **options))
    check_sorted(model)
    return model


class Point:
    """A sorted model evaluated at given candidates (guesses where they are not states).

    With None for `states`, the nearest point to the guesses that fits is taken.
    """

    def __init__(
        self,
        model: SortedDae,
        states: Mapping[str, float] | None,
        guesses: Mapping[str, float] | None = None,
        time: float = 0.0,
        events: Sequence[bool] = (),
    ) -> None:
        self.model = model
        self.time = time
        self.events = events
        self.states = states or {}
        self.any_fit = states is None
        self.guesses = guesses or {}
        self.values: dict[tuple[str, int], float] = {}
        for p in model.dae.parameters:
            self.values[p.name, 0] = self.value(p.value)
        for level in model.levels:
            for step in level.steps:
                self._run(step)

    def leaf(self, e: Expr) -> Any:
        match e.op:
            case Op.TIME:
                return self.time
            case Op.EVENT:
                return self.events[e.data]
        return self.values[e.data]

    def value(self, e: Expr) -> float:
        return float(evaluate(e, self.leaf))

    def of(self, name: str) -> float:
        """The value of any variable of the model, aliases included."""
        for a in self.model.aliases:
            if a.name == name:
                return a.sign * self.value(a.target)
        return self.values[name, 0]

    def _run(self, step: Assignment | Block) -> None:
        if isinstance(step, Assignment):
            self.values[step.target.data] = self.value(step.value)
            return
        given = {t: self.states[str(t)] for t in step.tears if str(t) in self.states}
        if step.residuals and len(given) == len(step.tears):  # all are known: they must fit
            self.values.update({t.data: v for t, v in given.items()})
            misfit = self._residuals(step, [], np.array([]))
            assert np.max(np.abs(misfit)) < 1e-9, f"{step.tears} do not fit: {misfit}"
            return
        solved = [t for t in step.tears if t not in given]
        assert self.any_fit or len(solved) == len(step.residuals), (
            f"states of {step.tears}: {list(given)}"
        )
        self.values.update({t.data: v for t, v in given.items()})
        x = np.array([self.guesses.get(str(t), 0.0) for t in solved])
        for _ in range(30):
            r = self._residuals(step, solved, x)
            if not len(r) or np.max(np.abs(r)) < 1e-13:
                break
            h = 1e-7
            columns = [
                (self._residuals(step, solved, x + h * unit) - r) / h
                for unit in np.eye(len(solved))
            ]
            x = x - np.linalg.lstsq(np.array(columns).T, r, rcond=1e-7)[0]
        r = self._residuals(step, solved, x)
        assert not len(r) or np.max(np.abs(r)) < 1e-8, f"no solution of {step.tears}: {r}"

    def _residuals(self, block: Block, solved: list[Expr], x: np.ndarray) -> np.ndarray:
        self.values.update({t.data: float(v) for t, v in zip(solved, x, strict=True)})
        for a in block.inner:
            self.values[a.target.data] = self.value(a.value)
        return np.array([self.value(r.value) for r in block.residuals])


@pytest.fixture(scope="session")
def point() -> type[Point]:
    return Point


@pytest.fixture(scope="session")
def planar() -> ModuleType:
    """The module `planar.py` beside this file."""
    path = Path(__file__).with_name("planar.py")
    spec = importlib.util.spec_from_file_location("structure_planar", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
