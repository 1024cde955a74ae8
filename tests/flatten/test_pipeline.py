"""What a flat model says beside its equations: structure, drawing, experiment, parts."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable

import pytest

from planarc.core.diagnostic import PlanarcError
from planarc.ir import flat
from planarc.ir.text.flat import print_expression, print_model

Flatten = Callable[..., flat.FlatModel]

PIN = "connector Pin Real v; flow Real i; end Pin;"
RESISTOR = PIN + (
    "model R parameter Real R = 1; Pin p; Pin n; equation p.v - n.v = R*p.i; p.i + n.i = 0; end R;"
)


def structural(model: flat.FlatModel) -> set[str]:
    return {v.name for v in model.variables if v.structural}


def test_what_shapes_the_model_is_structural_with_all_it_depends_on(
    flatten_text: Flatten,
) -> None:
    model = flatten_text(
        """
        model T
          parameter Integer n = 2*m;
          parameter Integer m = 1;
          parameter Boolean on = true;
          parameter Boolean choose = true;
          parameter Real k = 3;
          parameter Boolean evaluated = false annotation(Evaluate=true);
          Real x[n] = fill(k*time, n);
          Real y = 1 if on;
          Real z;
        equation
          if choose then z = 1; else z = k; end if;
        end T;
        """
    )
    assert structural(model) == {"n", "m", "on", "choose", "evaluated"}


def test_what_a_state_select_comes_from_is_structural_though_evaluated_before(
    flatten_text: Flatten,
) -> None:
    model = flatten_text(
        """
        model T
          model Body
            parameter Boolean enforce = false annotation(Evaluate=true);
            final parameter StateSelect select =
              if enforce then StateSelect.always else StateSelect.avoid;
            Real x(stateSelect=select);
          equation
            der(x) = 1;
          end Body;
          parameter Boolean enforce = false;
          Body body(enforce=enforce);
        end T;
        """
    )
    assert structural(model) == {"enforce", "body.enforce", "body.select"}


def test_parameters_in_if_expressions_stay_free(flatten_text: Flatten) -> None:
    model = flatten_text(
        "model T parameter Boolean b = true; Real x = if b then time else 2; end T;"
    )
    assert structural(model) == set()
    assert isinstance(model.variables[1].binding, flat.If)


def test_final_and_protected_are_kept(flatten_text: Flatten) -> None:
    model = flatten_text(
        """
        model M parameter Real p = 1; protected Real hidden = p; end M;
        model T M m(final p=2); final parameter Real q = 1; end T;
        """
    )
    assert {v.name for v in model.variables if v.final} == {"m.p", "q"}
    assert {v.name for v in model.variables if v.protected} == {"m.hidden"}


def test_visuals_hold_expressions_in_the_models_variables(flatten_text: Flatten) -> None:
    model = flatten_text(
        """
        model Shape
          input Real length = 1;
          Real twice = 2*length;
          parameter String kind = "box";
          annotation(__planarc(visual="shape"));
        end Shape;
        model Part
          parameter Boolean animation = true;
          parameter Real L = 2;
          Real x = time;
          Shape shape(length=L + x) if animation;
        end Part;
        model T Part a(L=3); Part b(animation=false); end T;
        """
    )
    assert [(v.component, v.kind) for v in model.visuals] == [("a.shape", "shape")]
    shown = {name: print_expression(e) for name, e in model.visuals[0].attributes}
    assert shown == {"length": "'a.L' + 'a.x'", "twice": "2 * ('a.L' + 'a.x')", "kind": '"box"'}
    assert not any(v.name.startswith("a.shape") for v in model.variables)


def test_experiment(flatten_text: Flatten) -> None:
    model = flatten_text(
        """
        model T
          constant Real n = 5;
          Real x = time;
          annotation(experiment(StartTime=1, StopTime=2*n, Interval=1/100, Tolerance=1e-8));
        end T;
        """
    )
    assert model.experiment == flat.Experiment(1.0, 10.0, 0.01, 1e-8)
    assert flatten_text("model T Real x = time; end T;").experiment == flat.Experiment()


def test_parts_and_connection_sets(flatten_text: Flatten) -> None:
    model = flatten_text(
        RESISTOR
        + """
        model T
          R a; R b[2];
        equation
          connect(a.n, b[1].p); connect(b[1].n, b[2].p); connect(b[1].p, b[2].n);
        end T;
        """
    )
    assert [(p.name, p.class_name) for p in model.parts if "." not in p.name] == [
        ("a", "R"),
        ("b[1]", "R"),
        ("b[2]", "R"),
    ]
    assert model.connections == (("a.n", "b[1].p", "b[2].n"), ("b[1].n", "b[2].p"))


def test_every_equation_knows_its_component_and_place(flatten_text: Flatten) -> None:
    text = "model M\n  Real x;\nequation\n  x = 1;\nend M;\nmodel T\n  M m;\nend T;\n"
    (equation,) = flatten_text(text).equations
    assert (equation.component, equation.span.line) == ("m", 4)


def test_a_package_constant_may_be_an_array_or_a_record(flatten_text: Flatten) -> None:
    model = flatten_text(
        """
        package P
          record R Real a; Real b[2]; end R;
          constant R r = R(1, {2, 3});
        end P;
        model T Real x = P.r.a + P.r.b[2]; parameter P.R q = P.r; end T;
        """
    )
    assert print_expression(model.variables[0].binding) == "1.0 + 3.0"  # type: ignore[arg-type]
    assert [v.name for v in model.variables] == ["x", "q.a", "q.b"]


@pytest.mark.parametrize(
    ("statements", "value"),
    [
        ("y := 0; for i in 1:4 loop y := y + i; end for;", 10.0),
        ("y := 1; while y < 50 loop y := 2*y; end while;", 64.0),
        ("y := 0; for i in 1:9 loop if i > 3 then break; end if; y := y + 1; end for;", 3.0),
        ("y := 5; if n > 2 then return; end if; y := 6;", 5.0),
        ("v := {k^2 for k in 1:n}; y := v[end] + sum(v);", 23.0),
        ("v := zeros(n); v[2:3] := {7, 8}; y := v*{1, 10, 100};", 870.0),
        ("m := [1, 2; 3, 4]; y := (m*transpose(m))[2, 2];", 25.0),
        ("y := mod(-7, 3) + div(7, 2) + rem(-7, 3) + integer(2.7);", 6.0),
    ],
)
def test_functions_run_while_compiling(
    flatten_text: Flatten, statements: str, value: float
) -> None:
    model = flatten_text(
        f"""
        function f
          input Integer n;
          output Real y;
        protected
          Real v[n];
          Real m[2, 2];
        algorithm
          {statements}
        end f;
        package P constant Real k = f(3); end P;
        model T Real x = P.k; end T;
        """
    )
    binding = model.variables[0].binding
    assert isinstance(binding, flat.Literal) and binding.value == pytest.approx(value)


def test_division_by_zero_while_compiling(flatten_text: Flatten) -> None:
    with pytest.raises(PlanarcError) as caught:
        flatten_text("package P constant Real k = 1/0; end P; model T Real x = P.k; end T;")
    assert [d.code for d in caught.value.diagnostics] == ["F283"]


def test_a_long_sum_does_not_exhaust_the_stack(flatten_text: Flatten) -> None:
    model = flatten_text("model T Real x = " + "+".join(["time"] * 900) + "; end T;")
    assert print_model(model).count("time") == 900


def test_deep_classes_end_in_a_message_or_a_model(flatten_text: Flatten) -> None:
    depth = 90
    text = "model M0 Real x = time; end M0;"
    for i in range(1, depth):
        text += f"model M{i} M{i - 1} m; end M{i};"
    assert len(flatten_text(text).variables) == 1
    for i in range(depth, 200):
        text += f"model M{i} M{i - 1} m; end M{i};"
    with pytest.raises(PlanarcError) as caught:
        flatten_text(text)
    assert {d.code for d in caught.value.diagnostics} == {"F251"}


def chain(links: int) -> str:
    lines = [RESISTOR, "model T", f"R r[{links}];", "equation"]
    lines += [f"connect(r[{k}].n, r[{k + 1}].p);" for k in range(1, links)]
    return "\n".join([*lines, "end T;"])


def test_the_cost_grows_with_the_number_of_components(
    flatten_text: Flatten, steps_of: Callable[[Callable[[], object]], int]
) -> None:
    def steps(links: int) -> int:
        text = chain(links)
        return steps_of(lambda: flatten_text(text))

    steps(2)
    assert steps(400) < 2.2 * steps(200)


PROGRAM = """
import sys
from pathlib import Path
from planarc.core.resources import stdlib
from planarc.core.source import Source
from planarc.flatten.library.library import Library
from planarc.flatten.pipeline import flatten
from planarc.ir.text.flat import print_model
from planarc.parse.parser import parse_annotation, parse_file, parse_text
library = Library([stdlib()], parse_file, parse_annotation)
names = library.add_file(parse_text(Source("t.mo", sys.stdin.read())))
sys.stdout.write(print_model(flatten(library, names[-1])))
"""


def test_the_result_does_not_depend_on_the_hash_seed() -> None:
    outputs = set()
    for seed in ("0", "1"):
        done = subprocess.run(
            [sys.executable, "-c", PROGRAM],
            input=chain(5),
            capture_output=True,
            text=True,
            check=True,
            env={"PYTHONHASHSEED": seed, "PYTHONDONTWRITEBYTECODE": "1"},
        )
        outputs.add(done.stdout)
    assert len(outputs) == 1
