"""Studies as curves and points."""

from __future__ import annotations

import pytest

import planarc
from planarc.study.table import Study

pytest.importorskip("matplotlib").use("agg")

ROWS = tuple(({"a": x, "b": y}, {"m": x * y, "n": x}) for x in (2.0, 1.0) for y in (1.0, 3.0))
STUDY = Study("Test", ("a", "b"), ("m", "n"), ROWS, units={"a": "kg", "m": "N"})


def test_each_metric_has_a_panel_with_a_curve_for_each_other_parameter() -> None:
    axes = STUDY.plot()
    assert [ax.get_ylabel() for ax in axes] == ["m [N]", "n"]
    assert axes[-1].get_xlabel() == "a [kg]"
    curves = {line.get_label(): line.get_ydata().tolist() for line in axes[0].lines}
    assert curves == {"b = 1": [1.0, 2.0], "b = 3": [3.0, 6.0]}


def test_another_parameter_lies_along_x() -> None:
    (ax,) = [STUDY.plot("m", x="b")]
    assert ax.get_xlabel() == "b"
    assert len(ax.lines) == 2


def test_a_random_sample_is_dots() -> None:
    rows = tuple(({"a": i * 1.0, "b": i % 7.0 + i / 100}, {"m": 1.0 * i}) for i in range(30))
    ax = Study("Test", ("a", "b"), ("m",), rows).plot()
    assert len(ax.collections) == 1
    assert not ax.lines


def test_what_cannot_be_drawn_is_told() -> None:
    with pytest.raises(planarc.UnknownName, match="no column `k`"):
        STUDY.plot("k")
    texts = Study("Test", ("a",), ("m",), (({"a": "fast"}, {"m": 1.0}),))
    with pytest.raises(planarc.UsageError, match=r"C202.*`a` are no numbers"):
        texts.plot()
    with pytest.raises(planarc.UsageError, match="nothing was varied"):
        Study("Test", (), ("m",), ()).plot()


def test_a_sweep_knows_units() -> None:
    text = """model M parameter Real k(unit="kg") = 1; Real x(start=1, fixed=true, unit="m");
    equation der(x) = -k*x; end M;"""
    study = planarc.sweep(planarc.load(text), {"k": [1.0], "x.start": [2.0]}, "max(x)", workers=1)
    assert study.units == {"k": "kg", "x.start": "m", "max(x)": "m"}
