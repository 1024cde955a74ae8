"""The editors' files agree with the language, the commands and the messages of planarc."""

from __future__ import annotations

import itertools
import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from planarc.cli.app import run
from planarc.core.source import SUFFIXES

ROOT = Path(__file__).parents[2]
VSCODE = ROOT / "editors" / "vscode"


def read(name: str) -> Any:
    return json.loads((VSCODE / name).read_text("utf-8"))


PACKAGE = read("package.json")
GRAMMAR = read("syntaxes/modelica.tmLanguage.json")
SNIPPETS = read("snippets/modelica.json")
CONTRIBUTED = PACKAGE["contributes"]


# The extension's own files


def test_every_file_that_the_extension_names_is_there() -> None:
    named = [
        *(language["configuration"] for language in CONTRIBUTED["languages"]),
        *(item["path"] for kind in ("grammars", "snippets") for item in CONTRIBUTED[kind]),
    ]
    for name in named:
        read(name)
    assert not [n for n in ("package.json", "README.md") if not (VSCODE / n).is_file()]


def test_the_extension_opens_the_endings_of_models() -> None:
    (language,) = CONTRIBUTED["languages"]
    assert sorted(language["extensions"]) == sorted(SUFFIXES)


def test_the_versions_are_exact_and_of_no_registry() -> None:
    """A lock file that names a host fails where another one is used."""
    lock = read("package-lock.json")
    assert not [n for n, package in lock["packages"].items() if "resolved" in package]
    for version in PACKAGE["devDependencies"].values():
        assert re.fullmatch(r"\d+\.\d+\.\d+", version)


# The grammar


def patterns(value: Any) -> Iterator[dict[str, Any]]:
    if isinstance(value, dict):
        yield value
        value = list(value.values())
    if isinstance(value, list):
        for item in value:
            yield from patterns(item)


def test_the_grammar_names_only_rules_that_it_has() -> None:
    rules = GRAMMAR["repository"]
    included = {p["include"] for p in patterns(GRAMMAR) if "include" in p} - {"$self"}
    assert included == {f"#{name}" for name in rules}


def test_every_keyword_of_the_language_has_a_colour() -> None:
    """Wherever it stands by itself; `der` and `initial` are called, `annotation` is opened."""
    text = (ROOT / "grammar" / "modelica.lark").read_text("utf-8")
    text = re.sub(r"\s//.*", "", text)
    keywords = set(re.findall(r'"([a-z]+)"', text)) | {"annotation", "initial", "end"}
    assert len(keywords) > 55
    rules = [p["match"] for p in patterns(GRAMMAR) if "match" in p]
    rules += [p["begin"] for p in patterns(GRAMMAR) if "begin" in p]
    named = [r for r in map(python_regex, rules) if "\\b" in r.pattern]
    for word in sorted(keywords):
        tried = (word, f"{word}(", f"{word} x")
        assert any(r.match(t) for r in named for t in tried), word


def python_regex(rule: str) -> re.Pattern[str]:
    # Python's lookbehind is of one length.
    return re.compile(re.sub(r"\(\?<=\[\(,\].*?\)", "", rule))


@pytest.mark.parametrize("name", ["r", "Real", "RealInput", "der2", "ending", "inner1", "forces"])
def test_a_name_that_begins_like_a_keyword_is_none(name: str) -> None:
    words = [p["match"] for p in patterns(GRAMMAR) if str(p.get("match", "")).startswith("\\b(?:")]
    assert len(words) > 4
    found = [w for w in words if re.fullmatch(w, name)]
    assert not found or name == "Real"


# Snippets


def expanded(body: list[str]) -> str:
    """What a user gets who only presses the tab key."""
    text = "\n".join(body)
    defaults = dict(re.findall(r"\$\{(\d+):([^{}]*)\}", text))
    text = re.sub(r"\$\{\d+\|([^,|]*)[^|}]*\|\}", r"\1", text)
    text = re.sub(r"\$\{(\d+)(?::[^{}]*)?\}", lambda m: defaults[m[1]], text)
    return text.replace("$0", "")


def whole(name: str) -> bool:
    return expanded(SNIPPETS[name]["body"]).startswith(("model ", "package ", "function "))


@pytest.mark.parametrize("name", [n for n in SNIPPETS if "inner" in "".join(SNIPPETS[n]["body"])])
def test_a_snippet_of_a_mechanism_passes_the_check(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = expanded(SNIPPETS[name]["body"])
    file = tmp_path / "snippet.pmo"
    file.write_text(text if whole(name) else f"model Part\n  {text}\nend Part;\n", "utf-8")
    assert run(["check", str(file), "--start"]) == 0, capsys.readouterr().err
    assert "warning" not in capsys.readouterr().err


@pytest.mark.parametrize("name", [n for n in SNIPPETS if n not in ("Model", "Package")])
def test_a_snippet_fits_where_it_belongs(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Components in a model with a world, equations in one with the variables that they name."""
    text = expanded(SNIPPETS[name]["body"])
    if whole(name):
        program = text if text.startswith("model ") else f"model Whole\n{text}\nend Whole;\n"
    elif text.startswith("inner "):
        program = f"model Whole\n{text}\nend Whole;\n"
    elif text.startswith(("if ", "for ", "when ", "assert", "connect", "annotation")):
        program = EQUATIONS[text.split("(")[0].split()[0]].format(text)
    else:
        program = f"model Whole\n  inner PlanarMultiBody.World world;\n{text}\nend Whole;\n"
    file = tmp_path / "whole.pmo"
    file.write_text(program, "utf-8")
    run(["check", str(file), "--json"])
    told = json.loads(capsys.readouterr().out)["diagnostics"]
    # What is alone is open or loose; it is no mistake of text, names or types.
    assert not [d for d in told if d["severity"] == "error" and d["code"][0] in "PC"]
    assert not [d for d in told if d["severity"] == "error" and "unknown" in d["message"]]


EQUATIONS = {
    "if": "model Whole\n  Real x;\nequation\n{}\nend Whole;\n",
    "for": "model Whole\n  Real y[3];\nequation\n{}\nend Whole;\n",
    "when": "model Whole\n  discrete Integer n(start=0, fixed=true);\nequation\n{}\nend Whole;\n",
    "assert": "model Whole\n  Real x=1;\nequation\n{}\nend Whole;\n",
    "connect": "model Whole\n  inner PlanarMultiBody.World world;\n"
    "  PlanarMultiBody.Parts.Fixed a;\n  PlanarMultiBody.Parts.Body b;\nequation\n{}\nend Whole;\n",
    "annotation": "model Whole\n  Real x=1;\n{}\nend Whole;\n",
}


def test_every_snippet_has_a_prefix_of_its_own() -> None:
    prefixes = [s["prefix"] for s in SNIPPETS.values()]
    assert len(set(prefixes)) == len(prefixes)
    assert all(s["description"] for s in SNIPPETS.values())


# Messages


@pytest.mark.parametrize("folder", ["plain", "with a space", "ö"])
def test_the_problem_matcher_reads_what_a_check_prints(
    folder: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (matcher,) = CONTRIBUTED["problemMatchers"]
    first, second = matcher["pattern"]
    file = tmp_path / folder / "bad.pmo"
    file.parent.mkdir()
    file.write_text(
        'model Bad\n  Reall x;\n  Real y(unit="m") = 1;\n  Real z(unit="s") = y;\nend Bad;\n',
        "utf-8",
    )
    assert run(["check", str(file)]) == 1
    lines = capsys.readouterr().err.splitlines()
    found = []
    for head, place in itertools.pairwise(lines):
        told, where = re.match(first["regexp"], head), re.match(second["regexp"], place)
        if told and where:
            found.append(
                (
                    told[first["severity"]],
                    told[first["code"]],
                    told[first["message"]],
                    where[second["file"]],
                    int(where[second["line"]]),
                    int(where[second["column"]]),
                )
            )
    assert found == [("error", "F210", "unknown name `Reall` in `Bad`", str(file), 2, 3)]


def test_tasks_are_commands_of_planarc(capsys: pytest.CaptureFixture[str]) -> None:
    (task,) = CONTRIBUTED["taskDefinitions"]
    for command in task["properties"]["command"]["enum"]:
        assert run([command, "--help"]) == 0
    assert capsys.readouterr().out


def test_helix_starts_the_language_server() -> None:
    text = (ROOT / "editors" / "helix" / "languages.toml").read_text("utf-8")
    settings = tomllib.loads(text)
    server = settings["language-server"]["planarc"]
    (language,) = settings["language"]
    assert [server["command"], *server["args"]] == ["planarc", "lsp"]
    assert language["language-servers"] == ["planarc"]
    assert sorted(f".{kind}" for kind in language["file-types"]) == sorted(SUFFIXES)


def test_the_commands_are_those_of_the_server_and_of_the_extension() -> None:
    pytest.importorskip("pygls")
    from planarc.editor.server import make_server

    server = make_server()
    server.session.stop()
    known = server.protocol.fm
    offered = {c["command"] for c in CONTRIBUTED["commands"]}
    served = set(known.commands)
    source = "".join(f.read_text("utf-8") for f in (VSCODE / "src").glob("*.ts"))
    own = set(re.findall(r'registerCommand\(\s*"([\w.]+)"', source))
    assert offered == served | own
    assert not served & own
    asked = set(re.findall(r'"(planarc/\w+)": \[', source))
    assert asked
    assert asked <= set(known.features)
