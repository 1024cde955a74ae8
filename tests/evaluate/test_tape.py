"""What an event sets: the same values as formulas give elsewhere, or a reason why not."""

from __future__ import annotations

import math
import random
from typing import Any

import pytest

from planarc import compiler
from planarc.core.options import Backend, RunOptions
from planarc.evaluate.tape import prepare, prepare_assignments
from planarc.evaluate.value import evaluate
from planarc.ir.expr import Expr, Exprs
from planarc.request.request import Request


@pytest.fixture(params=list(Backend), ids=[b.value for b in Backend])
def backend(request: pytest.FixtureRequest) -> Any:
    return request.param


def run(text: str, backend: Backend) -> Any:
    options = RunOptions(stop=2.0, intervals=20, backend=backend)
    return compiler.run(compiler.compile_model(Request(text=text), backend), options)


def test_a_division_by_zero_at_an_event_is_told_with_its_line(backend: Backend) -> None:
    result = run(
        """
model M
  Real x(start = 1, fixed = true);
  discrete Real mean(start = 0, fixed = true);
  Integer n(start = 2, fixed = true);
equation
  der(x) = -1;
  when sample(0.5, 0.5) then
    n = pre(n) - 1;
    mean = 3/n;
  end when;
end M;
""",
        backend,
    )
    assert result.ended is not None
    assert result.ended.code == "R421"
    assert "`mean`" in result.ended.message
    assert "1 s" in result.ended.message
    assert result.ended.span.line == 10
    assert result["mean"][-1] == 3.0


def test_a_reinit_without_value_is_told(backend: Backend) -> None:
    result = run(
        """
model M
  Real x(start = 1, fixed = true);
equation
  der(x) = -1;
  when x < 0.5 then
    reinit(x, sqrt(x - 1));
  end when;
end M;
""",
        backend,
    )
    assert result.ended is not None
    assert result.ended.code == "R421"
    assert "`x`" in result.ended.message


def test_a_branch_that_is_not_chosen_may_have_no_value(backend: Backend) -> None:
    result = run(
        """
model M
  discrete Real mean(start = 7, fixed = true);
  Integer n(start = -1, fixed = true);
equation
  when sample(0.5, 0.5) then
    n = pre(n) + 1;
    mean = if n > 0 then 6/n else -1;
  end when;
end M;
""",
        backend,
    )
    assert result.ended is None
    at = {t: result["mean"][result.time >= t + 0.01][0] for t in (0.5, 1.0, 1.5)}
    assert at == {0.5: -1.0, 1.0: 6.0, 1.5: 3.0}


# Prepared expressions ---------------------------------------------------------------------------


def _grown(table: Exprs, leaves: list[Expr], seed: int) -> Expr:
    """A random expression with shared parts, choices and operations without a value."""
    r = random.Random(seed)
    numbers, truths = list(leaves), [table.true]
    for _ in range(40):
        a, b = r.choice(numbers), r.choice(numbers)
        c, d = r.choice(truths), r.choice(truths)
        numbers.append(
            r.choice(
                [
                    table.add(a, b),
                    table.mul(a, b),
                    table.div(a, b),
                    table.neg(a),
                    table.call("sqrt", a),
                    table.call("atan2", a, b),
                    table.if_(c, a, b),
                ]
            )
        )
        made = [table.less(a, b), table.equal(a, b), table.not_(c), table.and_(c, d)]
        truths.append(r.choice([*made, table.or_(c, d)]))
    return numbers[-1]


@pytest.mark.parametrize("seed", range(60))
def test_a_prepared_expression_gives_what_the_expression_gives(seed: int) -> None:
    table = Exprs()
    names = ["a", "b", "c"]
    leaves = [*(table.symbol(n) for n in names), table.time, table.zero, table.const(2.0)]
    root = _grown(table, leaves, seed)
    w = [0.0, 1.5, -0.7]
    prepared = prepare(root, lambda e: names.index(e.name))

    def leaf(e: Expr) -> float:
        return 0.25 if e is table.time else w[names.index(e.name)]

    def outcome(value: Any) -> Any:
        try:
            found = value()
        except (ArithmeticError, ValueError):
            return None
        return None if math.isnan(found) else pytest.approx(found, rel=1e-12)

    assert outcome(lambda: prepared(w, 0.25)) == outcome(lambda: evaluate(root, leaf))


@pytest.mark.parametrize("seed", range(40))
def test_prepared_assignments_give_what_one_by_one_they_give(seed: int) -> None:
    table, r = Exprs(), random.Random(seed)
    names = [f"x{i}" for i in range(6)]
    leaves = [*(table.symbol(n) for n in names), table.time, table.zero, table.const(2.0)]
    assignments = [(r.randrange(6), _grown(table, leaves, seed * 100 + i)) for i in range(12)]
    begin = [r.choice([0.0, 1.5, -0.7]) for _ in names]

    w, expected = list(begin), -1
    for i, (slot, root) in enumerate(assignments):
        try:
            value = float(
                evaluate(root, lambda e: 0.25 if e is table.time else w[names.index(e.name)])
            )
        except (ArithmeticError, ValueError):
            value = math.nan
        if math.isnan(value):
            expected = i
            break
        w[slot] = value
    found = list(begin)
    assign = prepare_assignments(assignments, lambda e: names.index(e.name))
    assert assign(found, 0.25) == expected
    assert found == pytest.approx(w, rel=1e-12)

    others = [v if i in assign.reads else v + 1.0 for i, v in enumerate(begin)]
    again = list(others)
    assert assign(again, 0.25) == expected
    set_ = [slot for slot, _ in assignments[: expected if expected >= 0 else None]]
    assert [again[slot] for slot in set_] == [found[slot] for slot in set_]


def test_a_long_buffer_is_filled_at_an_index_that_varies(backend: Backend) -> None:
    """1,500 samples into as many elements, and their sum at every one of the last thirty."""
    result = run(
        """
model M
  constant Integer n = 1500;
  Real buffer[n](start = zeros(n), each fixed = true);
  Integer k(start = 0, fixed = true);
  discrete Real total(start = 0, fixed = true);
algorithm
  when sample(0.001, 0.001) then
    k := pre(k) + 1;
    if k <= n then
      buffer[k] := time;
    end if;
    if k > n - 30 and k <= n then
      total := sum(buffer);
    end if;
  end when;
end M;
""",
        backend,
    )
    assert result.ended is None
    assert [result[f"buffer[{k}]"][-1] for k in (1, 700, 1500)] == pytest.approx([0.001, 0.7, 1.5])
    assert result["buffer[700]"][result.time < 0.6995][-1] == 0.0
    assert result["total"][-1] == pytest.approx(0.001 * 1500 * 1501 / 2)


def test_sums_of_thousands_of_terms_can_be_prepared() -> None:
    table = Exprs()
    terms = [table.symbol(f"x{i}") for i in range(4000)]
    prepared = prepare(table.add(*terms), lambda e: int(e.name[1:]))
    assert prepared([float(i) for i in range(4000)], 0.0) == 4000 * 3999 / 2
