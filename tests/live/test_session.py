"""What a page gets for what it moves."""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import planarc
from planarc.core.options import Backend
from planarc.live.session import Order, Overtaken, Session
from planarc.request.request import Request

CAM = "PlanarMultiBody.Examples.CurveCurveJoint.CamFollower"
CURVES = "PlanarMultiBody.Curves"


def fields(answer: Any) -> dict[str, Any]:
    return {f["name"]: f for g in answer["model"]["groups"] for f in g["fields"]}


def test_fields_come_when_the_model_is_another_one(session: Session) -> None:
    first = session.answer(Order())
    assert first["model"]["name"] == "Swing"
    assert "model" not in session.answer(Order(known=first["key"]))
    again = session.answer(Order(known=first["key"], values={"heavy": 1.0}))
    assert fields(again)["heavy"]["value"] == 1.0
    assert fields(again)["second.m"]["value"] == 1.0
    assert "second.m" not in fields(first)
    ((kind, note),) = again["notes"]
    assert kind == "remark"
    assert note.startswith("`heavy` is structural: compiled again in ")
    # Going back, and there again, compiles nothing.
    assert session.answer(Order(known=again["key"]))["key"] == first["key"]
    assert session.answer(Order(values={"heavy": 1.0}))["notes"] == []


def test_answers_are_json_and_the_same_as_a_run(session: Session, swing: Request) -> None:
    order = Order(values={"L": 2.0, "n": 3.0}, starts={"hinge.phi": 0.1}, stop=0.7)
    answer = session.answer(order)
    json.dumps(answer, allow_nan=False)
    assert answer["problems"] == []
    result = session.result(order)
    direct = planarc.load(str(swing.file)).simulate(
        0.7, parameters={"L": 2, "n": 3}, start={"hinge.phi": 0.1}
    )
    assert result.time[-1] == 0.7
    np.testing.assert_allclose(result["bob.frame_a.f[2]"], direct["bob.frame_a.f[2]"], atol=1e-6)


def test_the_start_alone_comes_before_a_long_run(session: Session) -> None:
    whole = session.answer(Order())
    start = session.answer(Order(still=True, known=whole["key"]))
    assert (start["problems"], start["rows"]) == ([], 1)
    assert len(start["scene"]["items"]) == len(whole["scene"]["items"])
    json.dumps(start, allow_nan=False)


def test_a_text_that_was_edited_overtakes_the_run_of_the_old_one(session: Session) -> None:
    begun, reloaded = threading.Event(), threading.Event()
    go = session._base.model.run

    def slowly(*given: Any, progress: Any, **more: Any) -> Any:
        begun.set()
        while not reloaded.wait(0.01):
            progress(0.0)
        return go(*given, progress=progress, **more)

    session._base.model.run = slowly  # type: ignore[method-assign]
    told: list[object] = []

    def run() -> None:
        try:
            told.append(session.answer(Order()))
        except Overtaken as overtaken:
            told.append(overtaken)

    thread = threading.Thread(target=run)
    thread.start()
    assert begun.wait(60)
    session.reload()
    reloaded.set()
    thread.join(60)
    assert isinstance(told[0], Overtaken)
    assert session.answer(Order())["problems"] == []


def test_errors_stand_beside_the_field_that_they_name(session: Session) -> None:
    session.answer(Order())
    (found,) = session.answer(Order(starts={"hinge.phi": float("inf")}))["problems"]
    assert found["field"] == "hinge.phi.start"
    (found,) = session.answer(Order(values={"n": -1.0}, changed="n"))["problems"]
    assert found["field"] == "n"
    assert "mass m of a body is negative" in found["message"]
    (found,) = session.answer(Order(stop=-1.0, changed="$stop"))["problems"]
    assert found["field"] == "$stop"


def test_a_broken_file_is_told_and_a_mended_one_goes_on(session: Session, swing: Request) -> None:
    assert swing.file is not None
    good = swing.file.read_text("utf-8")
    swing.file.write_text(good.replace("equation", "equatoin"), "utf-8")
    session.reload()
    answer = session.answer(Order())
    assert "scene" not in answer
    assert "swing.pmo" in answer["problems"][0]["text"]
    swing.file.write_text(good.replace('= 1 "Length', '= 3 "Length'), "utf-8")
    session.reload()
    answer = session.answer(Order())
    assert answer["problems"] == []
    assert fields(answer)["L"]["value"] == 3.0


def test_a_mistake_of_planarc_is_told_in_a_line(
    session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: Any) -> None:
        raise ZeroDivisionError

    monkeypatch.delenv("PLANARC_DEBUG", raising=False)
    monkeypatch.setattr("planarc.live.session.make_scene", broken)
    (found,) = session.answer(Order())["problems"]
    assert found["code"] == "X001"
    assert "sorry, planarc made a mistake: ZeroDivisionError in " in found["message"]
    monkeypatch.undo()
    assert session.answer(Order())["problems"] == []


def test_values_of_what_is_not_there_do_no_harm(session: Session) -> None:
    """A page may still know fields of a model that was edited since."""
    answer = session.answer(Order(values={"gone": 1.0}, starts={"gone.x": 2.0}))
    assert answer["problems"] == []


@pytest.fixture(scope="module")
def cam() -> Session:
    return Session(Request(None, CAM), Backend.NATIVE)


def test_replaceable_curves_are_menus(cam: Session) -> None:
    choices = {c["component"]: c for c in cam.answer(Order())["model"]["choices"]}
    assert set(choices) == {"contact.curve1", "contact.curve2"}
    first = choices["contact.curve1"]
    assert first["current"] == f"{CURVES}.Ellipse"
    names = [o["name"].rpartition(".")[2] for o in first["options"]]
    assert {"Circle", "Ellipse", "StraightLine", "SinusEllipse", "Polar", "Spline"} <= set(names)
    assert names == sorted(names, key=str.lower)
    assert "BaseCurve" not in names  # partial
    assert len(names) == len(set(names))  # the older names of the same curves are not offered


def test_another_curve_takes_over_the_size_of_the_old_one(cam: Session) -> None:
    first = cam.answer(Order())
    assert "contact.curve1.R" not in fields(first)
    answer = cam.answer(
        Order(choices={"contact.curve1": f"{CURVES}.SinusEllipse"}, known=first["key"])
    )
    found = fields(answer)
    assert (found["contact.curve1.a"]["value"], found["contact.curve1.b"]["value"]) == (0.15, 0.08)
    circle = cam.answer(
        Order(choices={"contact.curve1": f"{CURVES}.Circle"}, values={"contact.curve1.R": 0.1})
    )
    assert circle["problems"] == []
    assert circle["model"]["name"] == CAM
    assert "contact.curve1.R" in fields(circle)
    assert "contact.curve1.a" not in fields(circle)


def test_only_what_was_offered_can_be_chosen(cam: Session) -> None:
    """A class name is put into the text of a model: nothing else may get there."""
    for component, name in (
        ("contact.curve1", "PlanarMultiBody.Parts.Body"),
        ("contact.curve1", "X; end X; model Y"),
        ("hinge", f"{CURVES}.Circle"),
    ):
        (found,) = cam.answer(Order(choices={component: name}))["problems"]
        assert found["code"] == "C281"


def notice_run(session: Session, monkeypatch: pytest.MonkeyPatch) -> threading.Event:
    """Set when the next run has got its turn."""
    begun = threading.Event()
    run = session._run

    def noticed(*arguments: Any) -> Any:
        begun.set()
        return run(*arguments)

    monkeypatch.setattr(session, "_run", noticed)
    return begun


def test_a_later_order_of_the_same_page_overtakes_a_run(
    session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run of minutes ends when its page asks for something else, and the answer says so."""
    session.answer(Order())
    ends: list[str] = []

    def long() -> None:
        try:
            session.answer(Order(stop=1e6, page="a"))
            ends.append("finished")
        except Overtaken:
            ends.append("overtaken")

    begun = notice_run(session, monkeypatch)
    thread = threading.Thread(target=long)
    thread.start()
    begun.wait()
    answer = session.answer(Order(values={"L": 2.0}, page="a"))
    thread.join()
    assert ends == ["overtaken"]
    assert answer["problems"] == []


def test_a_page_that_is_gone_stops_its_run(
    session: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    session.answer(Order())
    ends: list[type[Exception]] = []

    def long() -> None:
        try:
            session.answer(Order(stop=1e6, page="a"))
        except Overtaken as end:
            ends.append(type(end))

    begun = notice_run(session, monkeypatch)
    thread = threading.Thread(target=long)
    thread.start()
    begun.wait()
    session.leave("a")
    thread.join()
    assert ends == [Overtaken]


def test_elements_of_structural_arrays_have_fields() -> None:
    text = (
        "model Rows parameter Integer n[2](each min=1) = {1, 2}; parameter Integer big[20] ="
        " {i for i in 1:20}; Real x[n[1]] = fill(time, n[1]); Real y[n[2]] = fill(time, n[2]);"
        " Real z[big[20]] = fill(time, big[20]); end Rows;"
    )
    session = Session(Request(text=text), Backend.NUMPY)
    assert [name for name in fields(session.answer(Order())) if "[" in name] == ["n[1]", "n[2]"]
    order = Order(values={"n[2]": 3.0}, stop=1.0)
    answer = session.answer(order)
    assert answer["problems"] == []
    assert answer["notes"][0][1].startswith("`n[2]` is structural")
    names = session.result(order).names
    assert {"x[1]", "y[3]"} <= set(names)
    assert "x[2]" not in names


@pytest.mark.skipif(os.name != "posix", reason="named pipes of POSIX")
def test_a_pipe_in_the_place_of_the_file_is_told(session: Session, swing: Request) -> None:
    """Reading it would wait for ever."""
    assert swing.file is not None
    swing.file.unlink()
    os.mkfifo(swing.file)
    try:
        session.reload()
        (problem,) = session.answer(Order())["problems"]
        assert problem["code"] == "C108"
    finally:
        swing.file.unlink()


def test_a_moved_parameter_follows_the_last_assembly(
    folder: Path, steps_of: Callable[[Callable[[], object]], int]
) -> None:
    """Of the same values as a run that looks for its start, in a small part of the steps."""
    file = Path(__file__).parents[2] / "examples" / "four_bar.pmo"
    session = Session(Request(file), Backend.NUMPY)
    session.answer(Order(page="a"))
    order = Order(page="a", values={"crank.r[1]": 0.39})
    following = session.result(order)
    options = {"parameters": {"crank.r[1]": 0.39}}
    fresh = planarc.load(str(file)).simulate(backend="numpy", **options)
    for name in ("revB.phi", "revC.phi", "revD.w"):
        assert following[name] == pytest.approx(fresh[name], abs=1e-5)
    still = Order(page="a", values={"crank.r[1]": 0.38}, still=True)
    followed = steps_of(lambda: session.result(still))
    session.reload()
    assert followed < steps_of(lambda: session.result(still))


def test_where_no_assembly_is_near_it_is_looked_for_afresh(folder: Path) -> None:
    file = Path(__file__).parents[2] / "examples" / "four_bar.pmo"
    session = Session(Request(file), Backend.NUMPY)
    first = session.answer(Order(page="a"))
    broken = session.answer(Order(page="a", values={"coupler.r[1]": 9.0}))
    assert broken["problems"]
    again = session.answer(Order(page="a"))
    assert not again["problems"]
    assert again["curves"]["columns"] == first["curves"]["columns"]
