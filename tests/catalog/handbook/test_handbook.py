"""The handbook: every class has its entry, links lead somewhere, a library's text stays text."""

from __future__ import annotations

import base64
import hashlib
import re
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

import pytest

from planarc.catalog.handbook.code import colored
from planarc.catalog.handbook.gather import gather
from planarc.catalog.handbook.icon import icon_svg
from planarc.catalog.handbook.page import render_handbook
from planarc.catalog.handbook.pages import ClassPage, Graphic, Icon
from planarc.catalog.handbook.prose import clean
from planarc.request.request import Request, open_library


@cache
def pages(text: str = "") -> dict[str, ClassPage]:
    """All classes of the embedded libraries, or of a text."""
    request = Request(text=text) if text else Request()
    library, _, names = open_library(request)
    return {page.name: page for page in gather(library, names or library.top_names())}


@cache
def handbook() -> str:
    return render_handbook("libraries", tuple(pages().values()))


class Reader(HTMLParser):
    """Collects ids and links, and checks that elements close in order."""

    def __init__(self) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.tags: set[str] = set()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.tags.add(tag)
        if tag not in ("meta", "br", "hr", "input"):
            self.open.append(tag)
        self.ids += [i for i in [given.get("id")] if i]
        self.links += [h for h in [given.get("href")] if h]

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def read(text: str) -> Reader:
    reader = Reader()
    reader.feed(text)
    assert not reader.open
    return reader


@pytest.mark.parametrize("name", ["PlanarMultiBody", "Modelica"])
def test_every_class_has_an_entry(name: str) -> None:
    library, _, _ = open_library(Request())
    stack, names = [name], []
    while stack:
        names.append(stack.pop())
        entries = map(library.entry, (f"{names[-1]}.{i}" for i in library.class_names(names[-1])))
        stack += [e.full_name for e in entries if e and not e.definition.prefixes.protected]
    assert len(names) > 50
    assert set(names) <= set(read(handbook()).ids)


def test_links_resolve_and_nothing_is_fetched() -> None:
    reader = read(handbook())
    assert len(reader.ids) == len(set(reader.ids))
    inner = {link for link in reader.links if link.startswith("#")}
    assert len(inner) > 400
    assert {link[1:] for link in inner} <= set(reader.ids)
    assert reader.tags.isdisjoint({"link", "img", "iframe", "object"})
    (script,) = re.findall(r"<script>(.*?)</script>", handbook(), re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in handbook()
    assert "url(" not in handbook()
    assert "@import" not in handbook()


def test_the_same_library_gives_the_same_bytes() -> None:
    library, _, _ = open_library(Request())
    again = gather(library, library.top_names())
    assert render_handbook("libraries", again) == handbook()


def test_parameters_show_units_defaults_and_where_they_come_from() -> None:
    rows = dict(pages()["Modelica.Mechanics.Rotational.Components.SpringDamper"].tables)
    parameters = {row.name: row for row in rows["Parameters"]}
    assert parameters["c"].unit == "N.m/rad"
    assert parameters["phi_rel0"].value == "0"
    base = "Modelica.Mechanics.Rotational.Interfaces.PartialCompliantWithRelativeStates"
    origin = parameters["stateSelect"].origin
    assert origin is not None
    assert origin.target == base
    assert parameters["d"].type.target == "Modelica.Units.SI.RotationalDampingConstant"
    assert "flange_a" in {row.name for row in rows["Connectors"]}


def test_an_extends_clause_changes_the_shown_value() -> None:
    text = """
    package P
      partial model A parameter Real k = 1 "Gain"; end A;
      model B extends A(k = 2); end B;
    end P;
    """
    (heading, (row,)) = pages(text)["P.B"].tables[0]
    assert (heading, row.name, row.value) == ("Parameters", "k", "2")


def test_equations_are_shown_without_the_annotation() -> None:
    (text,) = pages()["Modelica.Mechanics.Rotational.Components.Spring"].equations
    assert text == "equation\n  tau = c*(phi_rel - phi_rel0);"


def test_the_head_of_a_class_tells_its_energy_also_that_of_its_bases() -> None:
    head = dict(pages()["PlanarMultiBody.Forces.Spring"].head)
    assert head["Energy"] == "potential = c*(s - s_unstretched)^2/2"
    source = dict(pages()["Modelica.Mechanics.Rotational.Sources.Torque"].head)
    assert source["Energy"].startswith("suppliedPower = -flange.tau")
    brake = dict(pages()["Modelica.Mechanics.Rotational.Components.Brake"].head)
    assert "sticks; comes free" in brake["Events"]


def test_the_head_of_a_class_tells_its_law() -> None:
    head = dict(pages()["PlanarMultiBody.Parts.Body"].head)
    first, *rest = head["Law"].split("\n")
    assert first == "r_0CM = ra + R(phia)*r_CM,"
    assert rest[-1].startswith("I*z = ta")
    assert head["Valid"] == "m >= 0, I >= 0; both may be 0."
    section = handbook().split('<section id="PlanarMultiBody.Parts.Body">')[1]
    law = (
        "<i>r</i><sub>0CM</sub> = <i>r</i><sub>a</sub> + R(<i>φ</i><sub>a</sub>)·"
        "<i>r</i><sub>CM</sub>,\n"
    )
    assert f"<dt>Law</dt><dd>{law}" in section
    assert "Check" not in head
    assert "tests/" not in re.sub(r"<pre>.*?</pre>", "", section.split("</section>")[0], flags=re.S)


def test_a_class_shows_inherited_equations_and_where_it_is_used() -> None:
    page = pages()["PlanarMultiBody.Forces.Spring"]
    (base, (text,)), *_ = page.inherited
    assert base.target == "PlanarMultiBody.Interfaces.PartialLineForce"
    assert "e = d_ab/max(s, s_small);" in text
    section = handbook().split('<section id="PlanarMultiBody.Forces.Spring">')[1]
    assert 'Used in <a href="#PlanarMultiBody.Examples.' in section.split("</section>")[0]


def test_an_example_lists_its_components_and_shows_its_text() -> None:
    name = "PlanarMultiBody.Examples.Elementary.Pendulum"
    rows = dict(pages()[name].tables)["Components"]
    assert [row.name for row in rows] == ["world", "hinge", "bob"]
    section = handbook().split(f'<section id="{name}">')[1].split("</section>")[0]
    assert '<details class="source" open>' in section


def test_the_only_root_is_shown_first() -> None:
    library, _, _ = open_library(Request())
    page = render_handbook("Parts", gather(library, ["PlanarMultiBody.Parts"]))
    assert page.count('class="start"') == 1
    assert page.rindex("<section") == page.index(
        '<section id="PlanarMultiBody.Parts" class="start">'
    )


def test_texts_of_the_language_are_coloured_and_escaped() -> None:
    assert colored('Real x "a<b"; // if') == (
        "Real x <span>&quot;a&lt;b&quot;</span>; <i>// if</i>"
    )
    assert colored("der(x) = end_1;") == "<b>der</b>(x) = end_1;"


def test_icons_merge_what_is_inherited() -> None:
    base = pages()["Modelica.Blocks.Interfaces.SISO"].icon
    icon = pages()["Modelica.Blocks.Math.Gain"].icon
    assert icon.graphics[: len(base.graphics)] == base.graphics
    assert len(icon.graphics) > len(base.graphics) > 0
    assert len(icon.connectors) == 2


def test_an_icon_turns_the_y_axis() -> None:
    line = Graphic("line", ((0.0, 10.0), (20.0, -30.0)))
    assert 'points="0,-10 20,30"' in icon_svg(Icon((line,)), "A", 100)


def test_bent_lines_and_arrows_are_drawn() -> None:
    points = ((0.0, 0.0), (10.0, 20.0), (20.0, 0.0))
    svg = icon_svg(Icon((Graphic("line", points, smooth=True, arrows=(False, True)),)), "A", 100)
    assert 'd="M0,0 L5,-10 Q10,-20 15,-10 L20,0"' in svg
    assert svg.count("<polygon") == 1
    assert '<polygon points="20,0 ' in svg


@pytest.mark.parametrize(
    ("given", "harmless"),
    [
        ("<p onclick='f()'>a</p>", "<p>a</p>"),
        ("<script>f()</script>b", "b"),
        ("<b><i>c</b>", "<b><i>c</i></b>"),
        ("<a href='javascript:f()'>d</a>", "<a>d</a>"),
        ("<a href='modelica://A.B'>e</a>", '<a href="#A.B">e</a>'),
        ("<a href='modelica://X'>f</a>", "<a>f</a>"),
        ("<img src='x' onerror='f()'>g &lt; h", "g &lt; h"),
        ("i</p></section>", "i"),
    ],
)
def test_documentation_is_made_harmless(given: str, harmless: str) -> None:
    assert clean(given, {"A.B"}) == harmless


def test_texts_of_a_model_are_escaped() -> None:
    evil = "</pre><script>f()</script>"
    text = f"""
    model M "{evil}"
      parameter String s = "{evil}" "{evil}";
      annotation(Icon(graphics={{Text(extent={{{{-1,-1}},{{1,1}}}}, textString="{evil}")}}));
    end M;
    """
    page = render_handbook(evil, tuple(pages(text).values()))
    assert page.count("<script") == 1  # its own
    assert read(page).ids == ["M"]


def test_the_command_writes_the_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from planarc.cli.app import run

    page = tmp_path / "book.html"
    assert run(["doc", "PlanarMultiBody.Parts", "--output", str(page)]) == 0
    assert re.search(r"written .*book\.html \(\d+ classes\)", capsys.readouterr().out)
    assert "PlanarMultiBody.Parts.Body" in read(page.read_text(encoding="utf-8")).ids


def test_a_page_of_someone_else_is_not_replaced(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from planarc.cli.app import run

    monkeypatch.chdir(tmp_path)
    (tmp_path / "Parts.html").write_text("mine", encoding="utf-8")
    assert run(["doc", "PlanarMultiBody.Parts"]) == 2
    assert "was not written by planarc" in capsys.readouterr().err
    assert (tmp_path / "Parts.html").read_text(encoding="utf-8") == "mine"


def test_an_unknown_class_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    from planarc.cli.app import run

    assert run(["doc", "PlanarMultiBody.Partz"]) == 2
    assert "did you mean `PlanarMultiBody.Parts`" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["<![foo[x]]>", "<![", "<![CDATA[x]]>", "<!x[y", "<?x", "<!--"])
def test_marked_sections_break_nothing_off(text: str) -> None:
    assert clean(f"a{text}<b>b</b>", ()).startswith("a")
    assert clean(f"<b>b</b>{text * 100}", ()).startswith("<b>b</b>")
