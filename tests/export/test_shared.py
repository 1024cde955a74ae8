"""What exported models share: a text that is written only where its objects are not known."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import pytest
from msgspec.structs import replace

from planarc.compiled import Compiled
from planarc.compiler import compile_model
from planarc.core import cache
from planarc.export import shared
from planarc.export.fmi import three, two
from planarc.export.fmu import make_fmu
from planarc.export.shared import Shared, Traits
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
            made = Shared(traits, entries, called)
            assert found.setdefault(made.key, made.text) == made.text
    assert len(set(found.values())) > len(found) // 2
    assert len({Shared(NONE, e, ()).key for e in versions}) == len(versions)
