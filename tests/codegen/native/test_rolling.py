"""Runs of equal statements as loops: found where they are, and equal to the last bit."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest

import planarc
from planarc.codegen.native import loops, machine, rolling
from planarc.codegen.native.printer import ir
from planarc.codegen.native.rolling import Roll, roll, roll_gathered
from planarc.core.options import RunOptions
from planarc.ir.expr import Expr, Exprs
from planarc.ir.program import Let, Program, Solve

pytest.importorskip("llvmlite")

EXAMPLES = Path(__file__).parents[3] / "examples"


def in_workspace(e: Expr) -> bool:
    return not e.name.startswith("$")


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever stands twice is rolled."""
    for name, value in (("SHORTEST", 1), ("FEWEST", 2), ("LEAST", 1), ("_PART", 2.0)):
        monkeypatch.setattr(rolling, name, value)


def rods(t: Exprs, count: int) -> list[Let]:
    """x1 := x0 + L1*c1, y1 := y0 - L1*c1, x2 := x1 + L2*c2, ..."""
    x, y, length, c = (
        [t.symbol(f"{name}{i}") for i in range(count + 1)] for name in ("x", "$y", "L", "c")
    )
    groups = [
        (
            Let(x[i], t.add(x[i - 1], t.mul(length[i], c[i]))),
            Let(y[i], t.sub(y[i - 1], t.mul(length[i], c[i]))),
        )
        for i in range(1, count + 1)
    ]
    return [let for group in groups for let in group]


def test_groups_of_equal_statements(short: None) -> None:
    t = Exprs()
    lets = rods(t, 5)
    (found,) = roll(lets, in_workspace)
    assert isinstance(found, Roll)
    assert found.body == tuple(lets[:2])
    assert [[e.name for e in column] for column in found.targets] == [
        [f"{name}{i}" for i in range(1, 6)] for name in ("x", "$y")
    ]
    read = {tuple(e.name for e in column) for column in found.leaves[0]}
    assert {tuple(f"x{i}" for i in range(5)), tuple(f"L{i}" for i in range(1, 6))} <= read


def test_what_is_left_as_it_is(short: None) -> None:
    """Another exponent, truth or leaf, what has no slot in place of what has one, blocks."""
    t = Exprs()
    a, b, x, y, hidden = (t.symbol(n) for n in ("a", "b", "x", "y", "$t"))
    two = t.const(2.0)
    for one, other in (
        (Let(x, t.pow(a, two)), Let(y, t.pow(b, t.const(3.0)))),
        (Let(x, t.div(t.sub(a, b), a)), Let(y, t.div(t.sub(a, b), b))),
        (Let(x, t.mul(two, a)), Let(y, t.mul(two, hidden))),
        (Let(x, t.mul(two, a)), Let(hidden, t.mul(two, b))),
        (Solve(0), Solve(1)),
        (Let(x, t.if_(t.less(a, b), a, b)), Let(y, t.if_(t.less(a, b), a, a))),
        (
            Let(x, t.equal(t.less(a, b), t.const(True))),
            Let(y, t.equal(t.less(a, b), t.const(False))),
        ),
    ):
        assert roll([one, other, other], in_workspace)[0] is one


def test_numbers_and_decisions(short: None) -> None:
    """Numbers are leaves as values are; an exponent is none, wherever else it stands."""
    t = Exprs()
    a, b, x, y = (t.symbol(n) for n in ("a", "b", "x", "y"))
    one, half = (t.const(n) for n in (1.5, 0.5))
    (found,) = roll(
        [
            Let(x, t.if_(t.less(a, one), t.mul(half, a), b)),
            Let(y, t.if_(t.less(b, half), t.mul(one, b), a)),
        ],
        in_workspace,
    )
    assert isinstance(found, Roll)
    assert {(one, half), (half, one), (a, b), (b, a)} == set(found.leaves[0])
    root = t.mul(half, t.pow(a, half))
    same = [Let(x, root), Let(y, t.mul(one, t.pow(b, half)))]
    assert roll(same, in_workspace) == same


def test_short_lists_stay_as_they_are() -> None:
    lets = rods(Exprs(), rolling.SHORTEST // 2 - 1)
    assert roll(lets, in_workspace) is lets


CHAIN = """model Chain
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute rev[N](phi(each start=0.1, each fixed=true));
  PlanarMultiBody.Parts.FixedTranslation rod[N](each r={1, 0});
  PlanarMultiBody.Parts.Body tip[N](each m=1, each I=0.1);
equation
  connect(world.frame_b, rev[1].frame_a);
  connect(rev.frame_b, rod.frame_a);
  connect(rod.frame_b, tip.frame_a);
  connect(rod[1:N - 1].frame_b, rev[2:N].frame_a);
end Chain;
"""


def simulated(program: Program) -> bytes:
    """A short run, with the code that the program has now."""
    from planarc.compiled import Compiled
    from planarc.compiler import run
    from planarc.core.options import Backend

    result = run(Compiled.of(program, Backend.NATIVE), RunOptions(stop=0.3, intervals=20))
    return b"".join(result[name].tobytes() for name in result.columns)


@pytest.mark.parametrize("model", ["four_bar", "cam_lift_off", "geneva_drive", "chain"])
def test_results_equal_to_the_last_bit(model: str, monkeypatch: pytest.MonkeyPatch) -> None:
    source = CHAIN.replace("N", "12") if model == "chain" else EXAMPLES / f"{model}.pmo"
    program = planarc.load(source).compiled().program
    found = []
    for shortest, fewest, least in ((10**9, 2, 1), (1, 2, 1), (20, 3, 4)):
        monkeypatch.setattr(rolling, "SHORTEST", shortest)
        monkeypatch.setattr(rolling, "FEWEST", fewest)
        monkeypatch.setattr(rolling, "LEAST", least)
        found.append((ir(program).count("\n"), simulated(program)))
    (straight, values), (rolled, same), (partly, as_well) = found
    assert straight not in (rolled, partly)
    assert values == same == as_well


def test_memory_has_an_end(monkeypatch: pytest.MonkeyPatch) -> None:
    program = planarc.load(CHAIN.replace("N", "12")).compiled().program
    monkeypatch.setattr(rolling, "SHORTEST", 1)
    rolled, before = ir(program), simulated(program)
    monkeypatch.setattr(loops, "MOST", 30)
    assert rolled.count("\n") < ir(program).count("\n")
    assert simulated(program) == before


def named(e: Expr) -> str:
    return e.name


def test_equal_statements_that_stand_apart(short: None) -> None:
    """$a := x*z, b := x, $c := y*z, d := $a + z, e := $c + z: what is read comes before."""
    t = Exprs()
    a, b, c, d, e, x, y, z = (t.symbol(n) for n in ("$a", "b", "$c", "d", "e", "x", "y", "z"))
    lets = [Let(a, t.mul(x, z)), Let(b, x), Let(c, t.mul(y, z)),
            Let(d, t.add(a, z)), Let(e, t.add(c, z))]  # fmt: skip
    lets += [Let(b, t.const(float(i))) for i in range(rolling.SHORTEST_SELDOM)]
    found = roll_gathered(lets, in_workspace, named)
    first = next(s for s in found if isinstance(s, Roll) and s.targets[0] == (a, c))
    assert first.targets == ((a, c), (d, e))
    set_in = [s.target for f in found for s in (f.statements if isinstance(f, Roll) else (f,))]
    assert sorted(e.name for e in set_in) == sorted(let.target.name for let in lets)


def test_what_sets_a_place_again_stays_behind_what_reads_it(short: None) -> None:
    """x := y, z := x, x := z + z: the last one stays the last one."""
    t = Exprs()
    x, y, z = (t.symbol(n) for n in ("x", "y", "z"))
    lets = [Let(x, y), Let(z, x), Let(x, t.add(z, t.const(1.0)))] * rolling.SHORTEST_SELDOM
    found = roll_gathered(lets, in_workspace, named)
    assert [s for f in found for s in (f.statements if isinstance(f, Roll) else (f,))] == lets


@pytest.mark.parametrize("model", ["dominoes", "chain"])
def test_small_code_gives_equal_results(model: str, monkeypatch: pytest.MonkeyPatch) -> None:
    source = CHAIN.replace("N", "12") if model == "chain" else EXAMPLES / f"{model}.pmo"
    program = planarc.load(source).compiled().program
    before = simulated(program)
    monkeypatch.setattr(machine, "ir", partial(ir, small=True))
    assert ir(program, small=True).count("\n") < ir(program).count("\n")
    assert simulated(program) == before


OSCILLATORS = """model Oscillators
  parameter Real k[N] = {1 + i/10 for i in 1:N};
  Real x[N](each start=1, each fixed=true);
  Real v[N](each start=0, each fixed=true);
equation
  for i in 1:N loop
    der(x[i]) = v[i];
    der(v[i]) = -k[i]*x[i] - 0.1*sin(v[i])*abs(v[i]);
  end for;
end Oscillators;
"""


def test_equal_parts_are_compiled_once() -> None:
    def lines(count: int) -> int:
        program = planarc.load(OSCILLATORS.replace("N", str(count))).compiled().program
        return ir(program).count("\n")

    assert lines(400) == lines(800) < 1000
