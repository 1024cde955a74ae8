"""What exported models share: a text that is written only where its objects are not known."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from planarc.compiled import Compiled
from planarc.compiler import compile_model
from planarc.core import cache, processes
from planarc.export import shared
from planarc.export.fmi import three, two
from planarc.export.fmu import make_fmu
from planarc.export.image import take_image
from planarc.export.module import write_whole
from planarc.export.pruned import asked_in
from planarc.export.shared import CALLED, Shared, Traits
from planarc.export.wishes import Wishes
from planarc.request.request import Request

pytest.importorskip("llvmlite")

EXAMPLES = Path(__file__).parents[2] / "examples"
NONE = Traits(False, False, False, False, False, False)


def exported(model: Compiled) -> bytes:
    return make_fmu(model, Wishes(platforms=("x86_64-linux", "x86_64-windows"))).data


def compiled(name: str) -> Compiled:
    return compile_model(Request(EXAMPLES / f"{name}.pmo"))


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(tmp_path))
    folder = cache.folder()
    assert folder is not None
    return folder / "native"


def refuse(*_: object) -> str:
    raise AssertionError("the text is written")


def test_known_objects_need_no_text(kept: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model = compiled("four_bar")
    first = exported(model)
    with monkeypatch.context() as m:
        m.setattr(shared, "_whole", refuse)
        assert exported(model) == first
    for path in kept.iterdir():  # names stay, the objects that they name are gone
        if path.stat().st_size > 1000:
            path.unlink()
    assert exported(model) == first


@pytest.mark.parametrize("name", ["pendulum", "four_bar", "ratchet_and_pawl", "walking_leg"])
def test_the_text_is_written_once_whether_or_not_it_was_known_early(
    kept: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """What a model shares is begun before its own functions are there. Whether its numbers stand in
    a file is known behind them alone: that of the last one of these was not thought to."""
    written = shared._whole
    asked: list[bool] = []

    def counted(traits: Traits, *more: Any) -> str:
        asked.append(traits.apart)
        return written(traits, *more)

    monkeypatch.setattr(shared, "_whole", counted)
    monkeypatch.setattr(processes, "cores", lambda: 1)  # another one counts for itself
    first = exported(compiled(name))
    assert asked == {
        "pendulum": [False], "four_bar": [False], "ratchet_and_pawl": [True],
        "walking_leg": [False, True],
    }[name]  # fmt: skip
    asked.clear()
    assert exported(compiled(name)) == first
    assert not asked, "what is known is not begun again, whatever it was thought to be"


@pytest.mark.parametrize(
    "name", ["Elementary.BouncingMass", "Loops.AndrewsSqueezer", "Contacts.RockingBlock"]
)
def test_it_has_what_any_model_calls(name: str) -> None:
    model = compile_model(Request(None, f"PlanarMultiBody.Examples.{name}"))
    written = write_whole(model.program, take_image(model), three.functions(), "", 1e-8)
    asked = asked_in(written.own) | asked_in(written.derivatives) | asked_in(written.solver)
    assert {"pc_linear"} <= asked <= CALLED


def test_another_kind_of_model_needs_another_text(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    others = [compiled(name) for name in ("pendulum", "cam_lift_off")]
    exported(compiled("four_bar"))
    monkeypatch.setattr(shared, "_whole", refuse)
    for other in others:
        with pytest.raises(AssertionError, match="the text is written"):
            exported(other)


def test_the_key_tells_texts_apart() -> None:
    found: dict[tuple[str, ...], str] = {}
    versions = [two.functions(), three.functions(), three.functions(delayed=True)]
    names = ("touches", "delayed", "eventful", "derived", "apart")
    for entries, called in product(versions, ((), ("pc_linear", "px_reinit"))):
        for switched in ((), *((name,) for name in names), names):
            traits = replace(NONE, **dict.fromkeys(switched, True))
            made = Shared(traits, entries, frozenset(called))
            assert found.setdefault(made.key, made.text()) == made.text()
    assert len(set(found.values())) > len(found) // 2
    assert len({Shared(NONE, e, frozenset()).key for e in versions}) == len(versions)
