"""Every place of a name is found, however it is written: as part of a dotted name, beside comments.

The names of `TEXT` are told apart by their words alone, so that a renaming must change each word
of its name outside comments and strings, and nothing else.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from planarc.api.load import load
from planarc.editor.hover import hover
from planarc.editor.meaning import meaning_at, meaning_of
from planarc.editor.mentions import Kind, mentions_of
from planarc.editor.rename import rename
from planarc.editor.shelf import Shelf
from planarc.editor.texts import Text, Texts
from planarc.editor.view import View

TEXT = """// within Nowhere; nothing of Pack
package Pack "Pack = (Rod)"
  partial model Base
    parameter Real mass = 1;
    Real shared;
    Unit unit;
  end Base;
  model Unit
    parameter Real depth = 1;
    Real inside = depth;
  end Unit;
  package Inner
    type Kind = enumeration(soft, hard);
    record Pair
      Real left = 0;
      Real right = 0;
    end Pair;
    partial function Outline
      input Real u;
      output Real y;
    end Outline;
    function twice
      extends Outline;
      input Real factor = 2;
    algorithm
      y := factor*u;
    end twice;
    function apply
      input Outline shape;
      input Real place;
      output Real found = shape(place);
    end apply;
    constant Real gap = 3;
    connector Flange
      Real level;
      flow Real current;
    end Flange;
    model Tip
      Flange flange;
    equation
      flange.current = flange.level - time;
    end Tip;
    model Rod
      extends Pack . /* the Inner one */ Base(mass = Pack.Inner.gap, unit . depth = 3);
      Inner.Tip one_end, other_end;
    equation
      shared = mass;
      connect(one_end.flange, other_end.flange);
    end Rod;
    model Open
      extends Pack.Inner.Rod(break connect(one_end.flange, other_end.flange));
    end Open;
  end Inner;
  package 'the (odd) = one'
    model 'a = b'
      parameter Real 'c (d)' = 1;
    end 'a = b';
  end 'the (odd) = one';
  model Holder
    replaceable Pack.Inner.Rod part constrainedby Pack.Base(mass = 4);
    replaceable model Chosen = Pack.Inner.Rod constrainedby .Pack.Base;
    Chosen chosen;
  end Holder;
  model Use
    import Short = Pack.Inner /* soft */ . Rod;
    import Pack.Inner.{Pair, twice};
    import Pack.Inner.Kind "Rod";
    Inner.Open open_;
    .Pack.Inner.Rod rods[2](each /* mass */ mass = 2, each unit.depth = 3), more;
    Short short;
    Pair pair = Pack.Inner.Pair(left = 1, right = Inner.twice(3, factor = 1));
    Kind kind = Pack.Inner.Kind.soft;
    Holder holder(
      redeclare Pack.Inner.Rod part(mass = Inner.gap),
      redeclare model Chosen = .Pack.Inner.Rod(mass = 3));
    Real called = Pack.Inner.apply(function Pack.Inner.twice(factor = 3), rods[2].mass);
    Pack.'the (odd) = one'.'a = b' quoted('c (d)' = 3);
    Real total = sum(Pack.Inner.gap*rods[k].unit.inside for k in 1:2)
      + pair.left + quoted.'c (d)';
  initial equation
    assert(holder.part.mass > Pack.Inner.gap - 10, "Rod");
  end Use;
end Pack;
"""
PART = "// within Lib\nwithin /* Lib */ Lib;\nmodel Part\n  Lib.Deep.Leaf leaf;\nend Part;\n"
_OUTSIDE = re.compile(r'//[^\n]*|/\*.*?\*/|"[^"]*"', re.DOTALL)


def opened(content: str) -> tuple[Shelf, Text]:
    texts = Texts()
    text = texts.put(Path("names.pmo").absolute(), content)
    return Shelf(texts), text


def words(content: str, name: str) -> list[int]:
    """Where a name stands, outside comments and strings."""
    bare = _OUTSIDE.sub(lambda found: " " * len(found[0]), content)
    found = re.finditer(rf"(?<![\w']){re.escape(name)}(?![\w'])", bare)
    return [match.start() for match in found]


def test_the_text_is_a_model() -> None:
    assert load(TEXT, "Pack.Use").simulate(stop_time=0.1)["called"][-1] == 6.0


def test_renaming_changes_each_place_of_a_name_and_nothing_else() -> None:
    shelf, text = opened(TEXT)
    view = View(shelf, text)
    declared = {
        mention.name: mention
        for mention in mentions_of(text)
        if mention.kind in (Kind.DECLARATION, Kind.LITERAL)
    }
    assert len(declared) > 40
    for name, mention in declared.items():
        renaming = rename(shelf, (), meaning_of(view, mention), "changed")
        spans = [span for _, edited in renaming.edits for span in edited]
        assert {span.text for span in spans} == {name}
        assert [span.start for span in spans] == words(TEXT, name)


def test_a_constraint_of_two_components_is_one_place() -> None:
    content = """package P
  model Base
    parameter Real k = 1;
  end Base;
  model Pair
    replaceable P.Base a, b constrainedby P.Base(k = 2);
  end Pair;
end P;
"""
    _, text = opened(content)
    for name in ("P", "Base", "k"):
        assert sorted(m.span.start for m in mentions_of(text, name)) == words(content, name)


def test_within_is_a_place_of_its_package(tmp_path: Path) -> None:
    texts = Texts()
    text = texts.put(tmp_path / "Lib" / "Part.mo", PART)
    found = [(m.kind, m.path, m.span.start) for m in mentions_of(text, "Lib")]
    first, second = words(PART, "Lib")
    assert found == [
        (Kind.IMPORT, ("Lib",), first),
        (Kind.REFERENCE, ("Lib",), second),
    ]


@pytest.mark.parametrize(
    ("words_before", "name", "told"),
    [
        ("PlanarMultiBody.Joints.", "Revolute", "model Revolute"),
        ("PlanarMultiBody.", "Joints", "package Joints"),
        ("extends PlanarMultiBody.Parts.", "Body", "model Body"),
    ],
)
def test_a_part_of_a_dotted_type_tells_what_it_is(words_before: str, name: str, told: str) -> None:
    content = (
        "model M\n  extends PlanarMultiBody.Parts.Body;\n"
        "  PlanarMultiBody.Joints.Revolute h;\nend M;\n"
    )
    shelf, text = opened(content)
    view = View(shelf, text)
    at = content.index(words_before + name) + len(words_before) + 1
    shown = hover(view, at)
    assert shown is not None and told in shown.markdown and shown.span.text == name
    found = meaning_at(view, at)
    assert found is not None and found[1] is not None
    assert found[1].span.text == name and found[1].span.source.path is not None
