"""Events in programs: stored relations, their zero functions, discrete equations, actions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from msgspec.structs import replace

from planarc.codegen.native.machine import compile_object
from planarc.codegen.numpy.printer import source
from planarc.codegen.pipeline import generate
from planarc.core.source import NOWHERE
from planarc.ir.dae import Kind, Reinit, Relation, Sampler, Variable, When
from planarc.ir.program import Program
from planarc.ir.sorted import Alias, Assignment, Block, SortedDae
from planarc.solve.kernels import load
from tests.ir.check.program import check

PRINTERS: dict[str, Callable[[Program], str | bytes]] = {
    "numpy": source,
    "native": compile_object,
}


@pytest.fixture(params=PRINTERS)
def backend(request: pytest.FixtureRequest) -> Callable[[Program], Any]:
    print_program = PRINTERS[request.param]
    return lambda program: load(program, print_program(program))


@pytest.fixture
def thermostat(build: Callable[[str], Any]) -> SortedDae:
    """der(x) = if on then 1 else -x, where `on` follows x < limit; count counts it.

    The limit is an unknown that nothing but the zero function and results need.
    """
    b = build("Thermostat")
    t = b.t
    x, limit = b.variable("x"), b.variable("limit")
    b.variable("minus")
    p = b.parameter("p", 2.0)
    b.candidate(x, 0.0)
    b.aliases.append(Alias("minus", x, -1))
    b.level(1, Block((x,)))
    on = t.symbol("on")
    heating = t.if_(on, t.one, t.neg(x))
    b.level(
        0,
        b.assign(t.der(x), heating),
        b.assign(limit, t.add(p, t.mul(t.const(0.1), t.time))),
    )
    model: SortedDae = b.sorted()
    discretes = (
        Variable("on", Kind.BOOLEAN, start=t.true),
        Variable("count", Kind.INTEGER, start=t.const(5.0)),
    )
    dae = replace(
        model.dae,
        discretes=discretes,
        relations=(Relation(t.sub(t.neg(t.symbol("minus")), limit), True, False, "x < limit"),),
        samplers=(Sampler(t.zero, p),),
        whens=(When((("on", (Reinit(t.symbol("minus"), t.mul(t.const(0.5), x)),)),)),),
    )
    equations = (
        Assignment(on, t.event(0), 0),
        Assignment(
            t.symbol("count"),
            t.add(t.pre("count"), t.if_(t.and_(on, t.not_(t.pre("on"))), t.one, t.zero)),
            1,
        ),
    )
    return replace(model, dae=dae, discrete=equations)


def test_zero_function_uses_what_only_results_need(
    thermostat: SortedDae, backend: Callable[[Program], Any]
) -> None:
    program = generate(thermostat)
    check(program)
    kernel = backend(program)
    kernel.parameters()
    kernel.select([0])
    g = [0.0]
    assert kernel.roots(3.0, [1.25], g) == 0
    assert g[0] == pytest.approx(1.25 - 2.3)


def test_stored_values_decide_and_not_the_present_ones(
    thermostat: SortedDae, backend: Callable[[Program], Any]
) -> None:
    program = generate(thermostat)
    kernel = backend(program)
    kernel.parameters()
    kernel.select([0])
    on = next(d for d in program.discretes if d.name == "on")
    ydot = [0.0]
    for stored, expected in ((1.0, 1.0), (0.0, -9.0)):
        kernel.w[on.slot] = stored
        assert kernel.rhs(0.0, [9.0], ydot) == 0
        assert ydot[0] == expected


def test_discrete_equations_take_left_limits(
    thermostat: SortedDae, backend: Callable[[Program], Any]
) -> None:
    program = generate(thermostat)
    kernel = backend(program)
    kernel.parameters()
    on, count = program.discretes
    assert kernel.w[count.start] == 5.0
    assert kernel.w[on.start] == 1.0
    (relation,) = program.relations
    for event, before, expected in ((1, 0, 6), (1, 1, 5), (0, 0, 5), (0, 1, 5)):
        kernel.w[relation.slot] = float(event)
        kernel.w[on.pre] = float(before)
        kernel.w[count.pre] = 5.0
        assert kernel.discrete() == 0
        assert kernel.w[on.slot] == event
        assert kernel.w[count.slot] == expected


def test_actions_speak_of_what_is_computed(thermostat: SortedDae) -> None:
    """reinit(minus, x/2) of minus = -x is reinit(x, -x/2)."""
    program = generate(thermostat)
    ((branch,),) = (w.branches for w in program.whens)
    slot, pre, (action,) = branch
    assert (slot, pre) == (program.slots["on"], program.slots["pre(on)"])
    assert isinstance(action, Reinit)
    assert str(action.symbol) == "x"
    assert str(action.value) == "-0.5*x"


def test_samplers_and_flags_have_slots(thermostat: SortedDae) -> None:
    program = generate(thermostat)
    ((slot, start, interval, _),) = program.samplers
    assert slot == program.slots["$sample[0]"]
    assert (str(start), str(interval)) == ("0", "p")
    assert {"$initial", "$terminal"} <= program.slots.keys()
    assert program.relations[0].span == NOWHERE
