"""What is known while compiling: structural parameters, constants of packages, functions."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from planarc.core.diagnostic import PlanarcError
from planarc.ir import flat
from planarc.ir.text.flat import print_expression

Flatten = Callable[..., flat.FlatModel]


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
