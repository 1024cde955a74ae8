"""The command line as a whole: help, usage errors, mistakes of planarc's own, lazy imports."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest

from planarc.cli import check, console
from planarc.cli.app import run
from planarc.cli.commands import COMMANDS

HEAVY = ("numpy", "scipy", "sympy", "matplotlib", "llvmlite", "lark", "rich", "sksundae")


def modules_after(*arguments: str, folder: Path | None = None) -> set[str]:
    """The modules that a command has imported when it ends."""
    script = (
        "import sys; from planarc.cli.app import run; code = run(sys.argv[1:]);"
        "print(*sys.modules, file=sys.stderr); sys.exit(code)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, *arguments], capture_output=True, text=True, cwd=folder
    )
    assert done.returncode == 0, done.stderr
    return set(done.stderr.split())


def test_help_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--help"]) == 0
    shown = capsys.readouterr().out
    assert all(f"\n  {command} " in shown for command in COMMANDS)
    assert "..." not in shown.partition("Commands:")[2]


def test_no_arguments_show_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert run([]) == 0
    assert capsys.readouterr().out.startswith("Usage: planarc ")


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([command, "--help"]) == 0
    shown = capsys.readouterr().out
    assert f"Usage: planarc {command} " in shown
    assert f"Examples:\n    planarc {command}" in shown


def test_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["--version"]) == 0
    assert capsys.readouterr().out == f"planarc {version('planarc')}\n"


def test_the_package_runs_as_a_module() -> None:
    done = subprocess.run([sys.executable, "-m", "planarc", "--version"], capture_output=True)
    assert done.returncode == 0
    assert done.stdout.startswith(b"planarc ")


def test_a_misspelt_option_is_usage(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", "a.pmo", "--librari", "x"]) == 2
    assert capsys.readouterr().err.startswith("error[C100]: no such option")


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["--tolerance", "1e-3%"], "write a number, `1e-3`, or a hundredth of it for per cent"),
        (["--stop", "1,5"], "write `1.5`: decimals stand behind a point"),
        (["--intervals", "0.01"], "for a time between two rows, write `--interval 0.01`"),
        (["--stepsize", "0.1"], "did you mean `--interval`?"),
        (["--t_end", "3"], "did you mean `--stop`?"),
        (["--plot", "x"], "draw curves by `planarc plot RESULT.csv VARIABLE`"),
        (["--set", "a.m=3,b.m=4"], "`--set a.m=3 --set b.m=4`"),
    ],
)
def test_a_word_of_another_tool_is_answered(
    words: list[str], hint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["simulate", "a.pmo", *words]) == 2
    err = capsys.readouterr().err
    assert err.startswith("error[C1")
    assert err.rstrip().endswith(hint)


def test_a_file_without_its_command_is_simulated(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["arm.pmo"]) == 2
    assert "hint: write `planarc simulate arm.pmo`" in capsys.readouterr().err


def test_usage_errors_are_json_when_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["simulate", "a.pmo", "--json", "--stop", "late"]) == 2
    out, err = capsys.readouterr()
    answer = json.loads(out)
    assert (answer["ok"], answer["diagnostics"][0]["code"], err) == (False, "C100", "")


def test_a_mistake_of_planarc_is_one_line_and_70(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(*_: object) -> None:
        raise KeyError("secret")

    monkeypatch.setattr(check, "make_request", broken)
    monkeypatch.delenv("PLANARC_DEBUG", raising=False)
    assert run(["check", "a.pmo"]) == 70
    shown = capsys.readouterr().err
    assert shown.startswith("error[X001]: sorry, planarc made a mistake: KeyError in cli/test_app")
    assert "Traceback" not in shown
    monkeypatch.setenv("PLANARC_DEBUG", "1")
    with pytest.raises(KeyError):
        run(["check", "a.pmo"])


def test_a_reader_that_goes_away_ends_the_command_quietly() -> None:
    command = (
        f"{shlex.quote(sys.executable)} -m planarc list PlanarMultiBody | head -n 1 >/dev/null"
    )
    script = f"set -o pipefail; {command}; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True)
    assert done.returncode in (0, 141)  # 0 where the pipe took all of the text at once
    assert done.stderr == ""


def test_help_imports_nothing_heavy() -> None:
    found = modules_after("--help")
    assert not found & set(HEAVY)


def test_check_imports_no_numerics(tmp_path: Path) -> None:
    (tmp_path / "decay.pmo").write_text(
        "model Decay Real x(start=1); equation der(x) = -x; end Decay;", "utf-8"
    )
    found = modules_after("check", "decay.pmo", folder=tmp_path)
    assert not found & {"numpy", "scipy", "sympy", "matplotlib", "llvmlite", "sksundae", "typer"}


def test_check_of_a_mechanism_imports_no_scipy_and_no_sympy() -> None:
    example = Path(__file__).parents[2] / "examples" / "four_bar.pmo"
    found = modules_after("check", str(example))
    assert not found & {"scipy", "sympy", "matplotlib"}


def test_a_run_imports_nothing_that_it_has_no_use_for(tmp_path: Path) -> None:
    """Each of them is 0.1 to 1 ms of a run that takes 100 to 200."""
    example = Path(__file__).parents[2] / "examples" / "four_bar.pmo"
    command = ("simulate", str(example), "--no-report", "--output", "run.csv")
    idle = {"csv", "typer", "planarc.ir.text.flat", "planarc.view.table.table"}
    idle |= {f"planarc.flatten.tree.{name}" for name in ("computed", "sight")}
    idle |= {f"planarc.{name}" for name in ("lower.bounds", "codegen.held", "core.arrays")}
    assert not modules_after(*command, folder=tmp_path) & idle
    assert not modules_after(*command, folder=tmp_path) & {*idle, "threading", "llvmlite"}


def test_colour_needs_a_terminal_that_wants_it(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal:
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr(sys, "stdout", Terminal())
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("TERM", "xterm")
    assert console.may_colour(sys.stdout)
    monkeypatch.setenv("NO_COLOR", "1")
    assert not console.may_colour(sys.stdout)
    monkeypatch.delenv("NO_COLOR")
    monkeypatch.setenv("TERM", "dumb")
    assert not console.may_colour(sys.stdout)


def test_a_check_is_remembered_while_its_files_are_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "m.mo"
    file.write_text("model M\n  import SI = Modelica.Units.SI;\n  SI.Length x = 1;\nend M;\n")
    stages = {"planarc.flatten.pipeline", "planarc.lower.pipeline", "planarc.structure.pipeline"}
    assert stages <= modules_after("check", str(file))
    assert not stages & modules_after("check", str(file))
    assert run(["check", str(file)]) == 0
    assert capsys.readouterr().out.startswith("M is complete: 1 equation")
    file.write_text("model M\n  Real x;\nend M;\n")
    assert run(["check", str(file)]) == 1
    file.write_text("model M\n  Real x = 1;\n  Real y = x;\nend M;\n")
    assert run(["check", str(file)]) == 0
    assert "2 equations" in capsys.readouterr().out
