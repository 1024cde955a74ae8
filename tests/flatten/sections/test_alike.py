"""Equal parts once: copies of components are what opening each of them gives."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import pytest
from msgspec.structs import replace

from planarc.core.diagnostic import Diagnostic, PlanarcError
from planarc.core.resources import stdlib
from planarc.core.source import Source, Span
from planarc.flatten.library.library import Library
from planarc.flatten.pipeline import flatten
from planarc.flatten.sections import gather
from planarc.ir import flat
from planarc.parse.parser import parse_text

SHAPED = """
model A1 "arrays of components that differ in what shapes them"
  model Part
    parameter Integer n = 2;
    parameter Boolean flag = false;
    parameter Real k[n] = fill(2.0, n);
    parameter Real q = 2*sum(k);
    parameter Real hot(min=0) = q - 3;
    Real x[n](each start=1);
    Real y;
    Leaf a if flag;
    Leaf b[n](each c=q);
    Leaf d[n](c=k);
    Real e = y + 1;
  protected
    Real z = sum(x);
  initial equation
    if flag then x = ones(n); else x = zeros(n); end if;
  equation
    for i in 1:n loop der(x[i]) = -k[i]*x[i] + b[i].y; end for;
    if flag then y = 1; else y = sum(x); end if;
    assert(y < 1e9, getInstanceName() + " is large");
  end Part;
  model Leaf
    parameter Real c = 1;
    final parameter Real c2 = c^2;
    Real y(min=-10, max=c2);
    Integer m(start=0);
    Boolean on;
  algorithm
    y := c*time;
    y := y + 1;
  equation
    on = y > 2;
    when on then m = pre(m) + 1; end when;
  end Leaf;
  parameter Integer N = 3;
  parameter Real ks[3] = {1, 2, 3};
  Part same[N];
  Part sized[N](n={1, 2, 2});
  Part flags[3](flag={true, false, true}, each n=1);
  Part given[3](hot=ks, each y(start=3));
  Part none[0](each n=4);
  Part one[1](n={3});
  Part two[2, 2](q={{1, 2}, {3, 4}});
  Part s1(n=2), s2(n=2), s3(n=3), s4(n=2, q=5), s5(n=2, q=s4.q);
  Part t1(hot=given[2].q), t2(hot=t1.q);
  parameter Integer deep = sized[2].n + same[2].n;
  Real w[deep];
equation
  for i in 1:deep loop w[i] = same[1].x[1] + i; end for;
end A1;
"""

REPLACED = """
model A2 "redeclared, inner and outer, records, buses, functions"
  record Data
    parameter Real a = 1;
    parameter Real b = 2*a;
    parameter Integer n = 2;
  end Data;
  connector Pin Real v; flow Real i; end Pin;
  partial model Law
    Pin p, n;
    Real u = p.v - n.v;
  equation
    p.i + n.i = 0;
  end Law;
  model R extends Law; parameter Real r(min=0) = 1; equation u = r*p.i; end R;
  model C
    extends Law;
    parameter Real c = 1;
    parameter Real q0 = 0;
    Real q(start=q0, fixed=true);
  equation
    der(q) = p.i;
    q = c*u;
  end C;
  model Amb parameter Real T = 300; Real heat; end Amb;
  model Holder
    replaceable model Kind = R constrainedby Law;
    replaceable R inside constrainedby Law;
    parameter Data data;
    parameter Data other = Data(a=3);
    Kind kind;
    Pin p, n;
    outer Amb amb;
    inner Amb own(T=data.a);
    Sub sub;
    Real v[data.n] = fill(amb.T, data.n);
    function f input Real x; output Real y; algorithm y := x^2; end f;
    Real g = f(amb.T*time) + sub.t;
  equation
    connect(p, kind.p); connect(kind.n, inside.p); connect(inside.n, n);
    own.heat = time;
  end Holder;
  model Sub outer Amb own; Real t = own.T + own.heat; end Sub;
  model Ground Pin p; equation p.v = 0; end Ground;
  inner Amb amb(T=290);
  parameter Data d1(a=4);
  Holder h[3](each data=d1);
  Holder g[2](data={Data(a=1), Data(a=2)});
  Holder k[2](redeclare each model Kind = C, each data=d1);
  Holder m[2](redeclare each C inside(c=3), redeclare each model Kind = C(c=2));
  Holder w1(data=d1), w2(data=d1), w3(data(a=7)), w4(data(a=8, n=3));
  Holder w5(redeclare model Kind = C), w6(redeclare model Kind = C);
  Ground ground;
equation
  amb.heat = sin(time);
  for i in 1:3 loop connect(h[i].p, ground.p); connect(h[i].n, ground.p); end for;
  for i in 1:2 loop
    connect(g[i].p, ground.p); connect(k[i].p, ground.p);
    connect(m[i].p, k[i].n); connect(g[i].n, ground.p);
  end for;
  connect(w1.p, w2.n); connect(w2.p, w3.n); connect(w3.p, w4.n);
  connect(w4.p, ground.p); connect(w5.p, w6.n);
end A2;
"""

ARM = """
model Arm
  inner PlanarMultiBody.World world;
  PlanarMultiBody.Joints.Revolute joint[{0}](each phi(start=0.1));
  PlanarMultiBody.Parts.BodyShape link[{0}](each r={{1, 0}}, each m=1, each I=0.1);
equation
  connect(world.frame_b, joint[1].frame_a);
  for i in 1:{0} loop
    connect(joint[i].frame_b, link[i].frame_a);
  end for;
  for i in 2:{0} loop
    connect(link[i - 1].frame_b, joint[i].frame_a);
  end for;
end Arm;
"""

CLASSES = """
model A4 "values of classes that components hold, which no variable is named after"
  package P
    constant Real k = 1;
  end P;
  model T
    replaceable type X = Real;
    X x;
  equation
    der(x) = 1;
  end T;
  model H
    replaceable package Q = P;
    T t;
    Real y = Q.k;
  end H;
  H a(Q(k=2), t(X(start=2)));
  H b(Q(k=3), t(X(start=2)));
  H c(Q(k=3), t(X(start=5)));
  H d[2](Q(k={6, 7}), t(X(start={8, 9})));
  H e[3](each t(X(start=1)));
end A4;
"""

PART = """
model T
  model Part
    parameter Integer n = 2;
    parameter Real k(min=0) = 1;
    parameter Real twice(min=0) = k - 1;
    parameter Boolean on = true;
    Real x[n];
    Real y if on;
  equation
    x = fill(k*time, n);
  end Part;
  {}
end T;
"""

UNITS = """
model T
  model Part
    Real x;
    Real y(unit="m");
  equation
    x = time;
    y = x;
  end Part;
  Part a[2](x(unit={"m", "s"}));
end T;
"""

WRONG = {
    "one broken element among 80": "Part a[80](k={if i == 57 then {i} else i for i in 1:80});",
    "a value too few": "Part a[80](k=fill(1, 79));",
    "no each": "Part a[80](k=1);",
    "no such element": "Part a[8](each q=1);",
    "a negative size": "Part a[3](n={1, -1, 2});",
    "a size that is no number": 'Part a(n=2); Part b(n="two"); Part c(n=2);',
    "bounds of one": "Part a[9](k={2, 2, 2, 2, 0, 2, 2, 2, 2});",
    "absent in one": "Part a[3](on={true, false, true}); Real z = a[2].y;",
    "equations of some": "Part a[3]; equation a[2].x[1] = 1;",
    "a value that varies": "Part a[3](each k=time);",
    "an array of none": "Part a[0](each k=time);",
}


def outcome(make: Callable[[], flat.FlatModel]) -> object:
    """All that a model is, with its places, or what is wrong with it."""
    try:
        model = make()
    except PlanarcError as problem:
        return told(problem.diagnostics)
    placed = (*model.variables, *model.equations, *model.visuals, *model.parts)
    rest = replace(model, warnings=())
    return rest, told(model.warnings), [place(p.span) for p in placed]


def told(diagnostics: Iterable[Diagnostic]) -> list[object]:
    return [
        (d.code, d.message, place(d.span), d.hint, [(r.message, place(r.span)) for r in d.related])
        for d in diagnostics
    ]


def place(span: Span | None) -> object:
    return span and (span.source.name, span.start, span.end)


@pytest.mark.parametrize(
    "text",
    [
        SHAPED,
        REPLACED,
        CLASSES,
        UNITS,
        ARM.format(3),
        *(PART.format(wrong) for wrong in WRONG.values()),
    ],
    ids=["shaped", "replaced", "classes", "units", "arm", *WRONG],
)
def test_copies_are_what_opening_each_gives(
    text: str, flatten_text: Callable[..., flat.FlatModel], monkeypatch: pytest.MonkeyPatch
) -> None:
    copied = outcome(lambda: flatten_text(text))
    monkeypatch.setattr(gather, "kind_of", lambda node: None)
    assert copied == outcome(lambda: flatten_text(text))


def test_an_equal_part_opens_little(
    library: Callable[[Path], Library], monkeypatch: pytest.MonkeyPatch
) -> None:
    def opened(links: int) -> int:
        made, met = library(stdlib()), list[None]()
        names = made.add_file(parse_text(Source("test.mo", ARM.format(links))))
        flatten(made, names[-1], watch=lambda: met.append(None))
        return len(met)

    more = opened(13) - opened(3)
    monkeypatch.setattr(gather, "kind_of", lambda node: None)
    assert more < 0.5 * (opened(13) - opened(3))
