"""The experiment of a model, and the figures of its documentation."""

from __future__ import annotations

from collections.abc import Callable

from planarc.ir import flat

Flatten = Callable[..., flat.FlatModel]


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


def test_figures_keep_curves_over_time_and_formulas_of_them(flatten_text: Flatten) -> None:
    model = flatten_text(
        """
        model T
          Real x = time;
          annotation(Documentation(figures={Figure(title="F", preferred=true, plots={
            Plot(curves={Curve(y=x), Curve(y=2*x + sin(x)), Curve(x=x, y=x)}),
            Plot(curves={Curve(x=x, y=x)})})}));
        end T;
        """
    )
    (figure,) = model.figures
    assert figure.title == "F" and figure.preferred
    (plot,) = figure.plots
    assert plot.curves[0] == "x" and len(plot.curves) == 2
    (formula,) = plot.formulas
    assert formula.steps[-1] == ("apply", "+") and ("apply", "sin") in formula.steps
