"""What the README promises is what CI runs and what planarc does.

`pytest --update-golden` writes components that the library has since into the table.
"""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path

import pytest

from planarc.cli.app import run
from planarc.cli.commands import COMMANDS
from planarc.cli.exits import Exit

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text("utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)


def test_two_commands_set_everything_up_and_each_is_one_line() -> None:
    first, second = (block.rstrip("\n") for block in blocks("bash"))
    assert first.endswith(" && .venv/bin/planarc simulate examples/four_bar.pmo")
    assert re.search(r" && \.venv/bin/pytest\b[^&\n]*$", second)
    for command in (first, second):
        assert command.startswith("python3 -m venv ")
        assert "\n" not in command


def test_ci_runs_the_command_of_the_readme() -> None:
    script = (ROOT / ".ci" / "run").read_text("utf-8")
    function = re.search(r"^readme_command\(\) \{\n.*?^\}\n", script, re.MULTILINE | re.DOTALL)
    assert function is not None
    found = subprocess.run(
        ["bash", "-c", function[0] + "readme_command test"],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    assert found == blocks("bash")[1]
    assert "command=$(readme_command test)" in script


def test_the_model_of_the_readme_is_a_model(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (text,) = blocks("modelica")
    monkeypatch.chdir(tmp_path)
    Path("pendulum.pmo").write_text(text, "utf-8")
    code = run(["simulate", "pendulum.pmo"])
    assert code == 0, capsys.readouterr().err


def test_every_command_is_in_the_readme() -> None:
    named = re.findall(r"^\| `planarc ([a-z]+)", README, re.MULTILINE)
    assert len(named) == len(set(named))
    assert set(named) == COMMANDS.keys()


def test_the_error_of_the_readme_is_what_planarc_says() -> None:
    (shown,) = blocks("text")
    golden = (ROOT / "tests" / "errors" / "missing_equation.case").read_text("utf-8")
    assert shown in golden


def listed(package: str) -> list[str]:
    order = ROOT / "stdlib" / "PlanarMultiBody" / package / "package.order"
    return [name for name in order.read_text("utf-8").split() if name != "Internal"]


def test_every_component_of_the_readme_is_in_the_library_and_the_other_way_round(
    request: pytest.FixtureRequest,
) -> None:
    readme = README
    rows = re.findall(r"^\| `(Parts|Joints|Forces)` \| (.*) \|$", readme, re.MULTILINE)
    assert len(rows) == 3
    for package, text in rows:
        lacking = [f", `{name}`" for name in listed(package) if f"`{name}`" not in text]
        if lacking and request.config.getoption("--update-golden"):
            # Before what follows a semicolon: a group with a title of its own.
            first, *groups = text.split(";", 1)
            text = ";".join(("".join((first, *lacking)), *groups))
            readme = re.sub(rf"(^\| `{package}` \| ).*( \|$)", rf"\1{text}\2", readme, flags=re.M)
            (ROOT / "README.md").write_text(readme, "utf-8")
        assert set(re.findall(r"`(\w+)`", text)) == set(listed(package))


def test_every_exit_code_is_in_the_readme() -> None:
    paragraph = re.search(r"^Exit codes: (.*?)\n\n", README, re.MULTILINE | re.DOTALL)
    assert paragraph is not None
    listed = {int(n) for n in re.findall(r"(?<!\S)(\d+) ", paragraph[1])}
    assert listed == {code.value for code in Exit} - {Exit.BROKEN_PIPE}


def test_pictures_of_the_readme_are_there() -> None:
    pictures = re.findall(r"!\[[^\]]*\]\(([^)]+)\)", README)
    assert len(pictures) == 1
    assert (ROOT / pictures[0]).stat().st_size < 100_000


def test_extras_are_for_pictures_tables_editors_and_drawings_only() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    assert set(project["project"]["optional-dependencies"]) == {
        "plot",
        "pictures",
        "notebook",
        "tables",
        "lsp",
        "cad",
    }


def test_the_changelog_tells_nothing_twice() -> None:
    """Merges of entries that moved have told them twice."""
    text = (ROOT / "CHANGELOG.md").read_text("utf-8")
    entries = [" ".join(entry.split()) for entry in re.split(r"\n(?=- )", text)[1:]]
    begun = [entry[:50] for entry in entries]
    assert [b for b in begun if begun.count(b) > 1] == []
    assert text.count("## [Unreleased]") == text.count("### Added") == 1
