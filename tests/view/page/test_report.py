"""The page of a run: one file, no network, no way for a model's text to run."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

import planarc
from planarc.core.diagnostic import UsageError
from planarc.ir.expr import Exprs
from planarc.ir.flat import Part
from planarc.ir.mechanism import Joint, Link, Mechanism
from planarc.view.page.data import ROWS, curve_data, thin_rows
from planarc.view.page.figures import choose_figures
from planarc.view.page.report import render_page, write_report
from planarc.view.scene import make_scene

EVIL = "</script><script>alert(1)</script>&<img src=x onerror=alert(2)>"
TIME = np.linspace(0.0, 1.0, 11)
VENDOR = Path(__file__).parents[3] / "planarc" / "view" / "vendor"


@pytest.fixture
def pendulum(
    table: Exprs, result_of: Callable[..., Any], shape_of: Callable[..., Any]
) -> Callable[..., Any]:
    def make(time: Any = TIME, name: str = "Pendulum", description: str = "") -> Any:
        rod = shape_of(table, name, phi=table.symbol("hinge.phi"), length=1.0, shapeType="beam")
        columns = {"hinge.phi": np.sin(time), "hinge.w": np.cos(time), "energy": time**2, "g": 9.81}
        parts = (Part("hinge", "PlanarMultiBody.Joints.Revolute"),)
        units = {"hinge.phi": ("rad", "deg"), "hinge.w": ("rad/s", "")}
        made = result_of(table, time, columns, (rod,), name, parts, units, description)
        joints = (Joint("hinge", 2, 1, (0, 1), ()),)
        mechanism = Mechanism((Link("ground", (), 0), Link("rod", ())), joints)
        return replace(made, program=replace(made.program, mechanism=mechanism))

    return make


def data_of(page: str) -> Any:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)
    assert found
    return json.loads(found[1])


def numbers(column: Any, form: str = "<f4") -> Any:
    """A column of the page as the page's script reads it."""
    return np.frombuffer(base64.b64decode(column), form) if isinstance(column, str) else column


def curve_of(data: Any, name: str) -> tuple[Any, str]:
    """Values and unit of a variable on the page."""
    curves = data["curves"]
    _, index, factor, unit, _ = next(v for v in curves["variables"] if v[0] == name)
    return factor * numbers(curves["columns"][index]), unit


def shown(data: Any) -> list[str]:
    return [n for f in data["curves"]["figures"] if f["on"] for n in f["curves"]]


def test_the_joint_angles_are_shown_in_degrees(pendulum: Callable[..., Any]) -> None:
    result = pendulum()
    data = data_of(render_page(result, make_scene(result)))
    assert shown(data) == ["hinge.phi"]
    values, unit = curve_of(data, "hinge.phi")
    assert unit == "deg"
    np.testing.assert_allclose(values, np.degrees(np.sin(TIME)), rtol=1e-6)


def test_every_variable_and_parameter_is_on_the_page(pendulum: Callable[..., Any]) -> None:
    result = pendulum()
    data = data_of(render_page(result, make_scene(result)))
    assert [v[0] for v in data["curves"]["variables"]] == ["hinge.phi", "hinge.w", "energy", "g"]
    assert curve_of(data, "g")[0] == 9.81
    np.testing.assert_array_equal(numbers(data["curves"]["time"], "<f8"), TIME)


def test_the_motion_is_in_the_page(pendulum: Callable[..., Any]) -> None:
    result = pendulum()
    scene = data_of(render_page(result, make_scene(result)))["scene"]
    (rod,) = scene["items"]
    angle = numbers(scene["tracks"][rod["angle"][0]])
    np.testing.assert_allclose(angle, np.sin(TIME), rtol=1e-6)
    assert rod["length"] == 1.0


def test_chosen_curves_replace_the_rule(pendulum: Callable[..., Any], tmp_path: Path) -> None:
    result = pendulum()
    write_report(tmp_path / "a.html", result, make_scene(result), curves=["energy"])
    assert shown(data_of((tmp_path / "a.html").read_text(encoding="utf-8"))) == ["energy"]
    with pytest.raises(UsageError, match="no variable `entropy`"):
        write_report(tmp_path / "b.html", result, make_scene(result), curves=["entropy"])


def test_what_has_no_room_is_left_out_and_counted(
    table: Exprs, result_of: Callable[..., Any]
) -> None:
    columns = {f"x{i}": np.sin(TIME + i) for i in range(50)}
    result = result_of(table, TIME, columns)
    figures = choose_figures(result, ["x49"])
    data = curve_data(result, figures, room=2000)
    names = [v[0] for v in data["variables"]]
    assert "x49" in names
    assert 2 < len(names) < 50
    assert data["left_out"] == 50 - len(names)


def test_a_body_of_the_users_own_is_shown_where_no_joint_is() -> None:
    """A body is what says that it has kinetic energy, whatever its class is called."""
    text = """model Flight
  inner PlanarMultiBody.World world;
  model Brick
    extends PlanarMultiBody.Interfaces.PartialOneFrame_a;
    SI.Position r[2](start={0, 0}, each fixed=true);
    SI.Velocity v[2](start={1, 2}, each fixed=true);
  equation
    r = frame_a.r;
    v = der(r);
    frame_a.f = 2*(der(v) - {0, -9.81});
    frame_a.phi = 0;
    annotation(__planarc(energy(kinetic=v*v)));
  end Brick;
  import Modelica.Units.SI;
  Brick brick;
end Flight;
"""
    (figure,) = (
        f for f in choose_figures(planarc.load(text).simulate().rows) if f.title == "Bodies"
    )
    assert figure.curves == ("brick.r[1]", "brick.r[2]")


def test_texts_of_a_model_cannot_become_markup(pendulum: Callable[..., Any]) -> None:
    plain, evil = pendulum(), pendulum(name=EVIL, description=EVIL)
    honest = render_page(plain, make_scene(plain), [("Model", "x")])
    attacked = render_page(evil, make_scene(evil), [(EVIL, EVIL)])
    assert attacked.count("<script") == honest.count("<script") == 3
    assert "<img" not in attacked
    assert data_of(attacked)["scene"]["items"][0]["component"] == EVIL


def test_only_the_scripts_of_the_page_may_run_and_nothing_is_loaded(
    pendulum: Callable[..., Any],
) -> None:
    page = render_page(pendulum(), make_scene(pendulum()))
    policy = re.search(r'content="(default-src [^"]*)"', page)
    assert policy
    assert policy[1].startswith("default-src 'none'")
    for script in re.findall(r"<script>(.*?)</script>", page, re.S):
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy[1]
    assert not re.search(
        r"""(src|href)\s*=\s*["']""", re.sub(r"<script.*?</script>", "", page, flags=re.S)
    )


def test_the_same_result_gives_the_same_bytes(pendulum: Callable[..., Any], tmp_path: Path) -> None:
    pages = []
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        path = tmp_path / folder / "page.html"
        write_report(path, pendulum(), make_scene(pendulum()))
        pages.append(path.read_bytes())
    assert pages[0] == pages[1]


def test_a_large_result_is_thinned_and_the_page_says_so(pendulum: Callable[..., Any]) -> None:
    time = np.linspace(0.0, 100.0, 50_001)
    result = pendulum(time)
    page = render_page(result, make_scene(result))
    data = data_of(page)
    assert 0.5 * ROWS < len(numbers(data["curves"]["time"], "<f8")) <= ROWS
    assert data["curves"]["time"] == data["scene"]["time"]
    assert f"of {len(time)} rows" in page
    phi, _ = curve_of(data, "hinge.phi")
    assert max(phi) == pytest.approx(np.degrees(np.sin(time).max()), rel=1e-6)


def test_thinning_keeps_ends_and_peaks() -> None:
    column = np.zeros(100_000)
    column[[777, 50_123, 99_998]] = 5.0, -3.0, 7.0
    rows = thin_rows(len(column), [column]).tolist()
    assert {0, 777, 50_123, 99_998, 99_999} <= set(rows)
    assert rows == sorted(set(rows))


def test_a_small_result_is_not_thinned() -> None:
    assert thin_rows(501, [np.zeros(501)]).tolist() == list(range(501))


def test_values_that_are_not_finite_are_gaps(table: Exprs, result_of: Callable[..., Any]) -> None:
    values = np.where(TIME > 0.5, np.inf, TIME)
    result = result_of(table, TIME, {"x": values})
    data = {"curves": curve_data(result, choose_figures(result))}
    assert np.isnan(curve_of(data, "x")[0]).tolist() == np.isinf(values).tolist()


def test_a_page_that_cannot_be_written_is_a_usage_error(
    pendulum: Callable[..., Any], tmp_path: Path
) -> None:
    with pytest.raises(UsageError, match="cannot write"):
        write_report(tmp_path / "no" / "page.html", pendulum(), make_scene(pendulum()))


def test_vendored_files_are_the_published_ones() -> None:
    sums = re.findall(r"\| `([^`]+)` .* `([0-9a-f]{64})` \|", (VENDOR / "README.md").read_text())
    assert len(sums) == 2
    for name, digest in sums:
        assert hashlib.sha256((VENDOR / name).read_bytes()).hexdigest() == digest


def test_long_names_break_at_their_dots(pendulum: Callable[..., Any]) -> None:
    result = pendulum()
    page = render_page(result, make_scene(result), (("model", "Library.Examples.Pendulum: 1.5 m"),))
    assert "<dd>Library.<wbr>Examples.<wbr>Pendulum: 1.5 m</dd>" in page
