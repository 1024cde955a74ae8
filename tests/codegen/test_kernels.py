"""Both back ends run the same programs: equal to each other, to the formulas, to differences."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from planarc.codegen.native.machine import compile_object
from planarc.codegen.numpy.printer import kernel_source
from planarc.codegen.pipeline import generate
from planarc.evaluate.value import evaluate
from planarc.ir.expr import Expr, Op, text
from planarc.ir.program import Program
from planarc.ir.sorted import Assignment, SortedDae
from planarc.solve.kernels import load
from tests.ir.check.program import check

MODELS = ("filter", "pendulum", "four_bar", "nonlinear", "switched")
PRINTERS: dict[str, Callable[[Program], str | bytes]] = {
    "numpy": kernel_source,
    "native": compile_object,
}


@pytest.fixture(params=MODELS)
def model(request: pytest.FixtureRequest) -> SortedDae:
    found: SortedDae = request.getfixturevalue(request.param)
    return found


@pytest.fixture(params=PRINTERS)
def backend(request: pytest.FixtureRequest) -> Callable[[Program], Any]:
    print_program = PRINTERS[request.param]
    return lambda program: load(program, print_program(program))


def started(program: Program, kernel: Any) -> list[float]:
    """Parameters run and candidates brought onto the constraints; gives their values."""
    assert kernel.parameters() == 0
    u = np.array([kernel.w[c.start] for c in program.candidates], float)
    below = [(i, b) for i, b in enumerate(program.blocks) if b.height and b.residuals]
    r = np.zeros(sum(len(b.residuals) for _, b in below) + len(program.initial_residuals))
    for _ in range(30):
        assert kernel.residuals(0.0, u.tolist(), r) == 0
        at = 0
        for i, b in below:
            m = len(b.residuals)
            step = np.linalg.lstsq(np.array(kernel.jacobian(i)), r[at : at + m], rcond=None)[0]
            u[b.first : b.first + len(b.tears)] -= step
            at += m
    assert np.abs(r).max(initial=0.0) < 1e-13
    assert kernel.residuals(0.0, u.tolist(), r) == 0
    kernel.accept(0.0)
    return [float(x) for x in u]


def selection(program: Program) -> list[int]:
    return [b.first + i for b in program.blocks if b.height for i in range(b.free)]


def test_program_is_whole(model: SortedDae) -> None:
    check(generate(model))


def test_backends_agree_in_every_slot(model: SortedDae) -> None:
    program = generate(model)
    found = []
    for print_program in PRINTERS.values():
        kernel = load(program, print_program(program))
        u = started(program, kernel)
        chosen = selection(program)
        kernel.select(chosen)
        y = [u[i] + 1e-3 for i in chosen]
        ydot = [0.0] * len(y)
        assert kernel.rhs(0.01, y, ydot) == 0
        assert kernel.outputs(0.01, y) == 0
        assert list(ydot) == [kernel.w[program.candidates[i].derivative] for i in chosen]
        found.append([float(x) for x in kernel.w])
    assert found[0] == pytest.approx(found[1], rel=1e-13, abs=1e-14)


def test_every_equation_holds(model: SortedDae, backend: Callable[[Program], Any]) -> None:
    """The workspace satisfies all assignments and residuals of the sorted model."""
    program = generate(model)
    kernel = backend(program)
    u = started(program, kernel)
    chosen = selection(program)
    kernel.select(chosen)
    assert kernel.outputs(0.02, [u[i] + 2e-3 for i in chosen]) == 0

    def leaf(e: Expr) -> float:
        return float(kernel.w[0 if e.op is Op.TIME else program.slots[text(e)]])

    for level in model.levels:
        for step in level.steps:
            for a in (step,) if isinstance(step, Assignment) else step.inner:
                value = evaluate(a.value, leaf)
                assert leaf(a.target) == pytest.approx(value, rel=1e-11, abs=1e-12)
            for r in () if isinstance(step, Assignment) else step.residuals:
                assert abs(evaluate(r.value, leaf)) < 1e-11


def test_jacobians_match_differences(
    four_bar: SortedDae, backend: Callable[[Program], Any]
) -> None:
    program = generate(four_bar)
    kernel = backend(program)
    u = started(program, kernel)
    r = [[0.0] * 4, [0.0] * 4]
    h = 1e-6
    for block, rows in ((0, slice(0, 2)), (1, slice(2, 4))):
        kernel.residuals(0.0, u, r[0])
        exact = np.array(kernel.jacobian(block))
        for j in range(3):
            for sign, out in ((1, r[0]), (-1, r[1])):
                moved = list(u)
                moved[program.blocks[block].first + j] += sign * h
                kernel.residuals(0.0, moved, out)
            slope = (np.array(r[0][rows]) - np.array(r[1][rows])) / (2 * h)
            assert exact[:, j] == pytest.approx(slope, abs=1e-8)


def test_unrolled_jacobian_and_tangent_agree(
    four_bar: SortedDae, backend: Callable[[Program], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []
    for limit in (400, 0):
        monkeypatch.setattr("planarc.codegen.jacobian.LARGEST_UNROLLED", limit)
        program = generate(four_bar)
        check(program)
        assert all((b.tangent is None) == (limit > 0) for b in program.blocks)
        kernel = backend(program)
        u = started(program, kernel)
        kernel.select([0, 3])
        assert kernel.outputs(0.0, [u[0], u[3]]) == 0
        values = [float(kernel.w[c.derivative]) for c in program.candidates]
        matrices = [np.ravel(kernel.jacobian(i)) for i in range(3)]
        found.append(np.concatenate([values, *matrices]))
    assert found[0] == pytest.approx(found[1], rel=1e-12, abs=1e-13)


def test_every_choice_of_states_gives_the_same_motion(
    four_bar: SortedDae, backend: Callable[[Program], Any]
) -> None:
    program = generate(four_bar)
    kernel = backend(program)
    u = started(program, kernel)
    names = [c.slot for c in program.candidates] + [c.derivative for c in program.candidates]
    found = []
    for i in range(3):
        for j in range(3, 6):
            kernel.select([i, j])
            assert kernel.outputs(0.0, [u[i], u[j]]) == 0
            found.append([float(kernel.w[s]) for s in names])
    for other in found[1:]:
        assert other == pytest.approx(found[0], rel=1e-10, abs=1e-10)


def test_block_starts_from_the_accepted_point(
    four_bar: SortedDae, backend: Callable[[Program], Any]
) -> None:
    """A call far away leaves no trace: only `accept` moves the start."""
    program = generate(four_bar)
    kernel = backend(program)
    u = started(program, kernel)
    kernel.select([0, 3])
    first, again, far = [0.0] * 2, [0.0] * 2, [0.0] * 2
    assert kernel.rhs(0.01, [u[0] + 0.01, u[3]], first) == 0
    for shift in (0.3, -0.3, 0.2):
        kernel.rhs(0.3, [u[0] + shift, u[3]], far)
    assert kernel.rhs(0.01, [u[0] + 0.01, u[3]], again) == 0
    assert list(first) == list(again)


def test_block_without_solution_fails(
    four_bar: SortedDae, backend: Callable[[Program], Any]
) -> None:
    program = generate(four_bar)
    kernel = backend(program)
    kernel.parameters()
    kernel.w[program.slots["L3"]] = 0.05  # the rods cannot meet
    kernel.select([0, 3])
    assert kernel.rhs(0.0, [1.2, 0.5], [0.0, 0.0]) > 0
    assert kernel.failed_block == 0


def test_nonlinear_block_finds_its_root(
    nonlinear: SortedDae, backend: Callable[[Program], Any]
) -> None:
    program = generate(nonlinear)
    kernel = backend(program)
    started(program, kernel)
    for x in (-2.0, 0.0, 1.0, 8.0):  # z^3 + z = x + 2
        ydot = [0.0]
        assert kernel.rhs(0.0, [x], ydot) == 0
        z = -ydot[0]
        assert z**3 + z == pytest.approx(x + 2.0, abs=1e-12)


def test_number_that_is_not_finite_names_its_equation(
    pendulum: SortedDae, backend: Callable[[Program], Any]
) -> None:
    program = generate(pendulum)
    kernel = backend(program)
    kernel.w[program.slots["g"]] = float("inf")
    kernel.parameters()
    kernel.select([0, 1])
    assert kernel.rhs(0.0, [0.3, 0.0], [0.0, 0.0]) < 0
    assert "body.f" in program.equations[kernel.failed_equation].text


@pytest.mark.parametrize(("name", "equation"), [("L1", 1), ("m", 7)])
def test_block_that_is_not_finite_names_its_equation(
    four_bar: SortedDae, backend: Callable[[Program], Any], name: str, equation: int
) -> None:
    """In the position loop, and in the linear block of the accelerations."""
    program = generate(four_bar)
    kernel = backend(program)
    kernel.w[program.slots[name]] = float("nan")
    kernel.parameters()
    kernel.select([0, 3])
    assert kernel.rhs(0.0, [1.2, 0.5], [0.0, 0.0]) < 0
    assert kernel.failed_equation == equation
    assert program.blocks[0 if name == "L1" else 2].equations[0] == equation


def test_formula_outside_its_domain_fails(
    build: Callable[[str], Any], backend: Callable[[Program], Any]
) -> None:
    from planarc.ir.sorted import Block

    b = build("Root")
    x = b.variable("x")
    b.candidate(x, 1.0)
    b.level(1, Block((x,)))
    b.level(0, b.assign(b.t.der(x), b.t.neg(b.t.call("sqrt", x))))
    program = generate(b.sorted())
    kernel = backend(program)
    kernel.parameters()
    assert kernel.rhs(0.0, [4.0], ydot := [0.0]) == 0
    assert ydot[0] == -2.0
    assert kernel.rhs(0.0, [-1.0], ydot) < 0
    assert kernel.failed_equation == 0


def test_branch_is_not_evaluated_where_its_condition_fails(
    switched: SortedDae, backend: Callable[[Program], Any]
) -> None:
    """if x > 0 then sqrt(x) + 1/x else -x: at x = 0 and below neither may fail."""
    program = generate(switched)
    kernel = backend(program)
    kernel.parameters()
    for x in (2.0, 0.0, -3.0):
        assert kernel.rhs(0.0, [x], ydot := [0.0]) == 0
        expected = 2 * (x**0.5 + 1 / x) if x > 0 else -x
        assert ydot[0] == pytest.approx(expected)


def test_parameter_change_needs_no_compilation(
    filter: SortedDae, backend: Callable[[Program], Any]
) -> None:
    program = generate(filter)
    kernel = backend(program)
    kernel.w[program.slots["T"]] = 0.25
    kernel.parameters()
    kernel.rhs(0.0, [1.0], ydot := [0.0])
    assert ydot[0] == -4.0


def test_kernels_of_one_program_do_not_touch_each_other(
    pendulum: SortedDae, backend: Callable[[Program], Any]
) -> None:
    program = generate(pendulum)
    one, two = backend(program), backend(program)
    for kernel in (one, two):
        kernel.parameters()
        kernel.select([0, 1])
    one.rhs(0.0, [0.5, 0.0], first := [0.0, 0.0])
    two.rhs(0.0, [-0.5, 0.0], [0.0, 0.0])
    one.outputs(0.0, [0.5, 0.0])
    two.outputs(0.0, [-0.5, 0.0])
    assert one.w[program.slots["der(der(rev.phi))"]] == first[1]
    assert two.w[program.slots["der(der(rev.phi))"]] == -first[1]
