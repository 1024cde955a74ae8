"""What is parsed once comes from the cache: the same tree, without lark, whatever is in it."""

from __future__ import annotations

import gc
import pickle
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from planarc.core import cache
from planarc.core.diagnostic import PlanarcError
from planarc.core.source import Source
from planarc.ir import syntax
from planarc.parse import stored
from planarc.parse.parser import parse_annotation, parse_expression, parse_text

TEXT = """model M "text"
  Real x[3](each start = 1) = {1, 2, 3} annotation(Dialog(a = 1));
equation
  when initial() then x = y; end when;
  annotation(experiment(StopTime = 2));
end M;
"""


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "cache"
    monkeypatch.setenv("PLANARC_CACHE_DIR", str(folder))
    return folder / "planarc"


def entries(folder: Path) -> list[Path]:
    return sorted((folder / "syntax").glob("*"))


def test_the_stored_tree_is_the_same_and_points_into_the_new_text(own_cache: Path) -> None:
    first = parse_text(Source("a.pmo", TEXT))
    assert len(entries(own_cache)) == 1
    source = Source("b.pmo", TEXT)
    second = parse_text(source)
    assert second == first
    assert second.classes[0].span == (source, *first.classes[0].span[1:])
    assert second.classes[0].name_span.text == "M"


def test_a_process_needs_no_lark(own_cache: Path, tmp_path: Path) -> None:
    path = tmp_path / "M.pmo"
    path.write_text(TEXT, encoding="utf-8")
    script = (
        "import sys; from pathlib import Path\n"
        "from planarc.parse.parser import parse_annotation, parse_file\n"
        "tree = parse_file(Path(sys.argv[1]))\n"
        "print(parse_annotation(tree.classes[0].annotation)[0].name, 'lark' in sys.modules)\n"
    )
    command = [sys.executable, "-c", script, str(path)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (run.stdout, run.stderr) == ("('experiment',) False\n", "")


@pytest.mark.parametrize("damage", [b"", b"rubbish", pickle.dumps(print), b"\x80\x05."])
def test_a_damaged_entry_is_replaced(own_cache: Path, damage: bytes) -> None:
    tree = parse_text(Source("a.pmo", TEXT))
    (entry,) = entries(own_cache)
    entry.write_bytes(damage)
    assert parse_text(Source("a.pmo", TEXT)) == tree
    cache.store("syntax", entry.name, damage)  # with a right checksum
    assert parse_text(Source("a.pmo", TEXT)) == tree


def test_nothing_but_nodes_is_read(own_cache: Path, tmp_path: Path) -> None:
    written = tmp_path / "written"

    class Call:
        def __reduce__(self) -> tuple[object, ...]:
            return Path.touch, (written,)

    cache.store("syntax", "k", pickle.dumps(Call()))
    assert stored.load_tree(Source("a", ""), "k") is None
    assert not written.exists()


def test_errors_are_not_stored(own_cache: Path) -> None:
    for _ in range(2):
        with pytest.raises(Exception, match="expected"):
            parse_text(Source("a.pmo", "model"))
    assert entries(own_cache) == []


def test_without_a_cache_all_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLANARC_CACHE_DIR", "")
    assert parse_text(Source("a", TEXT)) == parse_text(Source("a", TEXT))


def test_a_tree_too_deep_to_store_is_parsed_each_time(own_cache: Path) -> None:
    text = "a" + " + a" * 900
    for _ in range(2):
        chain = parse_expression(text)
        assert isinstance(chain, syntax.Binary)
        assert chain.span.text == text


def test_equal_annotations_of_two_places_stay_apart(own_cache: Path) -> None:
    tree = parse_text(
        Source("a", "model M Real x annotation(a = 1); Real y annotation(b = 2); end M;")
    )
    body = tree.classes[0].body
    assert isinstance(body, syntax.Composition)
    names = []
    for element in body.elements:
        assert isinstance(element, syntax.Component)
        assert element.annotation is not None
        (argument,) = parse_annotation(element.annotation)
        assert isinstance(argument, syntax.ElementModification)
        names.append(argument.name)
    assert names == [("a",), ("b",)]


def test_the_collector_is_left_as_it_was(own_cache: Path) -> None:
    parse_expression("a + b")
    assert gc.isenabled()
    with pytest.raises(Exception, match="expected"):
        parse_expression("a +")
    assert gc.isenabled()


def test_threads_do_not_mix_their_errors(own_cache: Path) -> None:
    """Half of the texts are wrong, each in its own way."""
    found: dict[int, str] = {}

    def work(number: int) -> None:
        text = f"model M{number} equation x{number} = {'1' if number % 2 else ''}; end M{number};"
        try:
            found[number] = parse_text(Source(f"{number}", text)).classes[0].name
        except PlanarcError as error:
            found[number] = error.diagnostics[0].message

    threads = [threading.Thread(target=work, args=(n,)) for n in range(16)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    expected = {n: f"M{n}" if n % 2 else "expected an expression, not `;`" for n in range(16)}
    assert found == expected
