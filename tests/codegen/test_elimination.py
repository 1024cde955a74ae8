"""Large linear blocks: eliminated in a fixed order, or with pivoting where that is not safe."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.codegen.elimination import _Operations, _Work
from planarc.codegen.native.machine import compile_object
from planarc.codegen.native.operations import operate_function, operation_row, room
from planarc.codegen.native.sparse import value_slots
from planarc.codegen.numpy.printer import source
from planarc.codegen.pipeline import generate
from planarc.ir.program import Direct, Program
from planarc.ir.sorted import Block, SortedDae
from planarc.ir.sparse import operations_of
from planarc.solve.kernels import load
from tests.codegen.native.engine import compiled
from tests.ir.check.program import check

PRINTERS: dict[str, Callable[[Program], str | bytes]] = {
    "numpy": source,
    "native": compile_object,
}


def chain(build: Callable[[str], Any], n: int) -> SortedDae:
    """Unknowns z, with a[i] = p[i]*z[i] + q[i]*z[i+1] and a[i] + s[i]*a[i-1] = x*(i + 1)."""
    b = build(f"Chain{n}")
    t = b.t
    x = b.variable("x")
    b.candidate(x, 1.0)
    b.level(1, Block((x,)))
    p, q, s = (
        [b.parameter(f"{name}[{i}]", scale * (1.0 + 0.3 * ((i * step) % 5))) for i in range(n)]
        for name, step, scale in (("p", 1, 1.0), ("q", 2, 0.3), ("s", 3, 0.2))
    )
    z = [b.variable(f"z[{i}]") for i in range(n)]
    a = [b.variable(f"a[{i}]") for i in range(n)]
    inner, residuals = [], []
    for i in range(n):
        after = t.mul(q[i], z[i + 1]) if i + 1 < n else t.zero
        inner.append(b.assign(a[i], t.add(t.mul(p[i], z[i]), after)))
        before = t.mul(s[i], a[i - 1]) if i else t.zero
        right = t.mul(x, t.const(i + 1.0))
        residuals.append(b.residual(t.add(a[i], before, t.neg(right))))
    b.level(
        0,
        Block(tuple(z), tuple(inner), tuple(residuals), linear=True),
        b.assign(t.der(x), t.add(*z)),
    )
    sorted_model: SortedDae = b.sorted()
    return sorted_model


def expected(values: Callable[[str], float], n: int, x: float) -> np.ndarray[Any, Any]:
    """z by a dense solve."""
    a, r = np.zeros((n, n)), np.eye(n)
    for i in range(n):
        a[i, i] = values(f"p[{i}]")
        if i + 1 < n:
            a[i, i + 1] = values(f"q[{i}]")
        if i:
            r[i, i - 1] = values(f"s[{i}]")
    return np.linalg.solve(r @ a, x * np.arange(1.0, n + 1.0))


@pytest.fixture(params=PRINTERS)
def backend(request: pytest.FixtureRequest) -> Callable[[Program], Any]:
    print_program = PRINTERS[request.param]
    return lambda program: load(program, print_program(program))


def solved(program: Program, kernel: Any, n: int, x: float) -> list[float]:
    assert kernel.parameters() == 0
    kernel.select([0])
    assert kernel.outputs(0.0, [x]) == 0
    return [float(kernel.w[program.slots[f"z[{i}]"]]) for i in range(n)]


@pytest.mark.parametrize("n", [8, 30])
def test_elimination_solves_the_block(
    build: Callable[[str], Any], backend: Callable[[Program], Any], n: int
) -> None:
    program = generate(chain(build, n))
    check(program)
    assert program.blocks[-1].direct is not None
    kernel = backend(program)
    found = solved(program, kernel, n, 2.0)
    reference = expected(lambda name: kernel.w[program.slots[name]], n, 2.0)
    assert found == pytest.approx(reference.tolist(), rel=1e-10)


def test_operations_give_the_tears(
    build: Callable[[str], Any], backend: Callable[[Program], Any]
) -> None:
    """Without pivoting, which would give them, too."""
    n = 12
    program = generate(chain(build, n))
    kernel = backend(program)
    found = solved(program, kernel, n, 2.0)
    direct = program.blocks[-1].direct
    assert direct is not None
    assert by_operations(program, kernel, direct) == pytest.approx(found, rel=1e-10)


def by_operations(program: Program, kernel: Any, direct: Direct) -> list[float]:
    """The tears; nan where a pivot vanishes."""
    slots = program.slots
    numbers = [float(e.data if e.is_const else kernel.w[slots[str(e)]]) for e in direct.values]
    for a, negative, factors in operations_of(direct):
        product = math.prod(numbers[i] for i in factors) * (-1 if negative else 1)
        given = 0.0 if a is None else numbers[a]
        inverse = 1.0 / given if given else math.nan
        numbers.append(given + product if factors else inverse)
    return [numbers[ref >> 1] * (-1 if ref & 1 else 1) for ref in direct.tears]


#: Masses in a row that move each other, and rest on a floor or fly.
TOUCHING = """model Touching
  parameter Integer N = 10;
  discrete Boolean held[N](each start=false, each fixed=true);
  Real f[N], a[N];
equation
  for i in 1:N loop
    (1 + 0.1*i)*a[i] + 0.3*(if i > 1 then a[i - 1] else 0) + 0.2*(if i < N then a[i + 1] else 0)
      = cos(0.1*time)*f[i] - 9.81;
    0 = if held[i] then a[i] else f[i];
    when time > i then
      held[i] = true;
    end when;
  end for;
end Touching;
"""


@pytest.mark.parametrize("resting", [0, 0b1, 0b1010101010, 0b1111111111], ids=bin)
def test_the_order_suits_what_rests_and_what_flies(resting: int) -> None:
    """A coefficient that vanishes where a mass rests, or where it flies, is no pivot."""
    program = planarc.load(TOUCHING).program
    direct = program.blocks[-1].direct
    assert direct is not None
    kernel = load(program, compile_object(program))
    assert kernel.parameters() == 0
    for i in range(10):
        kernel.w[program.slots[f"held[{i + 1}]"]] = float(resting >> i & 1)
    assert kernel.outputs(0.0, []) == 0
    found = [kernel.w[program.slots[str(u)]] for u in direct.unknowns[: len(direct.tears)]]
    assert by_operations(program, kernel, direct) == pytest.approx(found, rel=1e-6)


def test_a_table_of_operations_gives_the_same_bits(build: Callable[[str], Any]) -> None:
    program = generate(chain(build, 12))
    direct = program.blocks[-1].direct
    assert direct is not None
    w = np.random.default_rng(1).uniform(-2.0, 2.0, program.size)
    places = value_slots(direct, program.slots)
    for e, slot in zip(direct.values, places, strict=True):
        if e.is_const:
            w[slot] = e.data
    numbers = w[places].tolist()
    for a, negative, factors in operations_of(direct):
        if not factors:
            numbers.append(1.0 / numbers[a])
            continue
        product = math.prod(numbers[i] for i in factors)
        given = -0.0 if a is None else numbers[a]
        numbers.append(given - product if negative else given + product)
    engine = compiled(operate_function())
    call = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)(engine.get_function_address("pc_operate"))
    row = np.array([*operation_row(direct, program.slots)], np.int64)
    memory = np.full(room(direct), np.nan)
    call(w.ctypes.data, row.ctypes.data, memory.ctypes.data)
    signs = (-1 if ref & 1 else 1 for ref in direct.tears)
    wanted = [numbers[ref >> 1] * sign for ref, sign in zip(direct.tears, signs, strict=True)]
    slots = [program.slots[str(tear)] for tear in program.blocks[-1].tears]
    assert w[slots].tolist() == wanted
    assert sorted(map(float.hex, memory)) == sorted(map(float.hex, numbers))


@pytest.mark.parametrize("zero", ["q[3]", "s[3]", "q[0]", "s[8]"])
@pytest.mark.parametrize("value", [0.0, 1e-14, 1e9])
def test_parameters_may_change_after_compiling(
    build: Callable[[str], Any], backend: Callable[[Program], Any], zero: str, value: float
) -> None:
    n = 9
    program = generate(chain(build, n))
    kernel = backend(program)
    kernel.w[program.slots[zero]] = value
    found = solved(program, kernel, n, 1.5)
    reference = expected(lambda name: kernel.w[program.slots[name]], n, 1.5)
    assert found == pytest.approx(reference.tolist(), rel=1e-7)


def test_singular_block_is_said(
    build: Callable[[str], Any], backend: Callable[[Program], Any]
) -> None:
    program = generate(chain(build, 9))
    kernel = backend(program)
    kernel.w[program.slots["p[8]"]] = 0.0
    kernel.parameters()
    kernel.select([0])
    assert kernel.outputs(0.0, [1.5]) > 0
    assert kernel.failed_block == len(program.blocks) - 1


def test_elimination_without_good_pivots_falls_back(
    build: Callable[[str], Any], backend: Callable[[Program], Any]
) -> None:
    """What the order took for large becomes tiny: the answer is still that of pivoting."""
    n = 12
    program = generate(chain(build, n))
    kernel = backend(program)
    for i in range(n):
        kernel.w[program.slots[f"p[{i}]"]] = 1e-9 if i % 2 else 1.0
        kernel.w[program.slots[f"s[{i}]"]] = 1e3 if i % 3 else 1e-3
    found = solved(program, kernel, n, 1.0)
    z, x = np.array(found), 1.0
    w = {name: float(kernel.w[slot]) for name, slot in program.slots.items()}
    a = [w[f"p[{i}]"] * z[i] + (w[f"q[{i}]"] * z[i + 1] if i + 1 < n else 0) for i in range(n)]
    sizes = [
        abs(w[f"p[{i}]"] * z[i]) + (abs(w[f"q[{i}]"] * z[i + 1]) if i + 1 < n else 0)
        for i in range(n)
    ]
    for i in range(n):
        before = w[f"s[{i}]"] * a[i - 1] if i else 0.0
        size = sizes[i] + (abs(w[f"s[{i}]"]) * sizes[i - 1] if i else 0.0) + x * (i + 1)
        assert abs(a[i] + before - x * (i + 1)) < 1e-10 * size


def test_code_grows_with_the_length_of_the_chain_only(build: Callable[[str], Any]) -> None:
    def length(n: int) -> int:
        program = generate(chain(build, n))
        return sum(map(len, program.levels)) + sum(len(b.jacobian_body) for b in program.blocks)

    assert length(80) < 2.2 * length(40)


def test_asked_matrix_is_that_of_the_block(
    build: Callable[[str], Any], backend: Callable[[Program], Any]
) -> None:
    n = 8
    program = generate(chain(build, n))
    kernel = backend(program)
    solved(program, kernel, n, 1.0)
    matrix = np.array(kernel.jacobian(len(program.blocks) - 1))
    right = np.arange(1.0, n + 1.0)
    found = [float(kernel.w[program.slots[f"z[{i}]"]]) for i in range(n)]
    assert np.linalg.solve(matrix, right) == pytest.approx(found, rel=1e-10)


@pytest.mark.parametrize("small", [1, 3])
def test_a_pivot_may_be_tiny_at_fewer_than_half_of_the_samples(small: int) -> None:
    """The last pivot of a long row of loops vanishes near one position or other."""
    work = pencil(small)
    assert work.run()
    assert [(i, j) for i, j, *_ in work.order] == [(0, 0), (1, 1)]


def test_a_pivot_that_is_tiny_at_most_samples_is_none() -> None:
    work = pencil(4)
    assert not work.run()


def pencil(small: int) -> _Work:
    """x = 1, d*y = 1, with d almost zero at so many of seven samples."""
    work = _Work(2, _Operations(1))
    one = work.done.number(1.0)
    work.add(one, [(0, one, np.ones(7))])
    work.add(one, [(1, 0, np.array([1e-12] * small + [1.0] * (7 - small)))])
    return work


def test_operations_with_0_and_1_are_done_before() -> None:
    """Of the numbers a and b, told by 0 and 2; 1 and 3 are their negatives."""
    done, a, b = _Operations(2), 0, 2
    zero, one, two = map(done.number, (0.0, 1.0, 2.0))
    assert done.sum(a, zero, b) == done.sum(a, b, zero) == a
    assert done.sum(zero, one, b) == done.sum(zero, b, one) == b
    assert done.sum(zero, done.number(-1.0), b) == b ^ 1
    assert done.sum(b, one, b ^ 1) == zero
    assert done.sum(one, two, two) == done.number(5.0)
    assert done.inverse(done.number(-2.0)) == done.number(-0.5)
    assert not done.listed


def test_operations_are_done_once_whatever_their_sign() -> None:
    done, a, b = _Operations(2), 0, 2
    first = done.sum(a, a, b)
    assert done.sum(a, a ^ 1, b ^ 1) == first
    assert done.sum(a ^ 1, a ^ 1, b) == first ^ 1
    assert done.inverse(b ^ 1) == done.inverse(b) ^ 1
    assert done.listed == [(a, a, b), (b,)]
