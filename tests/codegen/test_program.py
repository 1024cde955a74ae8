"""What a program promises to those who run it: columns, start values, constants, storage."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from planarc.codegen.numpy.printer import source
from planarc.codegen.pipeline import generate
from planarc.ir.program import Let, Program
from planarc.ir.sorted import Alias, Block, SortedDae
from planarc.ir.store import dumps, loads
from planarc.solve.kernels import load
from tests.ir.check.program import check


def run(program: Program, y: list[float], t: float = 0.0) -> dict[str, float]:
    """The values of all columns."""
    kernel = load(program, source(program))
    assert kernel.parameters() == 0
    assert kernel.outputs(t, y) == 0
    return {c.name: c.sign * float(kernel.w[c.slot]) for c in program.columns}


def test_columns_are_all_variables_then_derivatives_then_parameters(pendulum: SortedDae) -> None:
    names = [c.name for c in generate(pendulum).columns]
    assert names == [
        "rev.phi",
        "rev.w",
        "power",
        "body.f",
        "der(rev.phi)",
        "der(der(rev.phi))",
        "m",
        "L",
        "g",
        "I",
    ]


def test_aliases_are_read_with_their_sign(build: Callable[[str], Any]) -> None:
    b = build("Aliases")
    t = b.t
    x, p = b.variable("x"), b.parameter("p", 3.0)
    for name in ("minus", "twice", "fixed", "clock", "speed"):
        b.variable(name)
    b.candidate(x, 1.0)
    b.aliases += [
        Alias("minus", x, -1),
        Alias("twice", t.symbol("minus"), -1),
        Alias("fixed", t.mul(t.const(2.0), p), -1),
        Alias("clock", t.time, 1),
        Alias("speed", t.der(x), 1),
    ]
    b.level(1, Block((x,)))
    b.level(0, b.assign(t.der(x), t.neg(x)))
    program = generate(b.sorted())
    check(program)
    found = run(program, [5.0], t=7.0)
    assert found["minus"] == -5.0
    assert found["twice"] == 5.0
    assert found["fixed"] == -6.0
    assert found["clock"] == 7.0
    assert found["speed"] == -5.0
    constant = {c.name for c in program.columns if c.constant}
    assert constant == {"fixed", "p"}


def test_aliases_share_the_slot_of_what_they_stand_for(build: Callable[[str], Any]) -> None:
    b = build("Shared")
    x = b.variable("x")
    for name in ("a", "b", "zero1", "zero2"):
        b.variable(name)
    b.candidate(x, 0.0)
    b.aliases += [Alias("a", x, 1), Alias("b", x, -1)]
    b.aliases += [Alias(name, b.t.zero, 1) for name in ("zero1", "zero2")]
    b.level(1, Block((x,)))
    b.level(0, b.assign(b.t.der(x), x))
    slots = {c.name: c.slot for c in generate(b.sorted()).columns}
    assert slots["a"] == slots["b"] == slots["x"]
    assert slots["zero1"] == slots["zero2"]


def test_start_values_have_slots_of_their_own(nonlinear: SortedDae) -> None:
    """What a user writes there after `parameters` is what blocks start from."""
    program = generate(nonlinear)
    kernel = load(program, source(program))
    kernel.parameters()
    assert kernel.w[program.candidates[0].start] == 1.0
    ((slot, start),) = program.guesses
    assert slot == program.slots["z"]
    assert kernel.w[start] == 0.5
    kernel.w[start] = float("nan")
    assert kernel.rhs(0.0, [1.0], [0.0]) != 0  # it did start from there
    kernel.w[start] = 1.0
    assert kernel.rhs(0.0, [1.0], [0.0]) == 0


def test_what_only_results_need_is_not_in_the_levels(pendulum: SortedDae) -> None:
    program = generate(pendulum)
    levels = {str(s.target) for level in program.levels for s in level if isinstance(s, Let)}
    rest = {str(s.target) for s in program.rest if isinstance(s, Let)}
    assert "power" in rest
    assert "power" not in levels
    assert "body.f" in levels


def test_what_parameters_make_is_computed_once(build: Callable[[str], Any]) -> None:
    b = build("Once")
    t = b.t
    x, p = b.variable("x"), b.parameter("p", 2.0)
    half = b.variable("half")
    b.candidate(x, 1.0)
    b.level(1, Block((x,)))
    root = t.call("sqrt", t.add(p, t.one))
    b.level(0, b.assign(half, t.div(p, t.const(2.0))), b.assign(t.der(x), t.mul(root, x, half)))
    program = generate(b.sorted())
    moving = [str(s) for level in program.levels for s in level]
    assert not any("sqrt" in s or "p/2" in s for s in moving)
    column = {c.name: c for c in program.columns}["half"]
    assert column.constant
    assert run(program, [1.0])["der(x)"] == pytest.approx(3.0**0.5)


def test_stored_program_is_the_same_program(four_bar: SortedDae) -> None:
    program = generate(four_bar)
    again = loads(dumps(program, program.table))
    check(again)
    assert source(again) == source(program)
    for name in set(program.__struct_fields__) - {"table"}:
        assert repr(getattr(again, name)) == repr(getattr(program, name)), name
