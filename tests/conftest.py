"""What all tests share: golden files, shown with input and output together."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from msgspec.structs import replace

from planarc.core import processes
from planarc.core.options import Backend, Solver
from planarc.solve.kept import Kept

# How long an example takes says more about the machine than about planarc.
settings.register_profile("planarc", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("planarc")

# Jobs that a shell starts in the background ignore Ctrl-C, and so would what the tests start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

#: Seconds that a test waits for what is bound to come. Nobody waits where all is well.
PATIENCE = 300.0

GOLDEN = Path(__file__).parent / "golden"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden",
        action="store_true",
        help="rewrite the golden files; read them as a reviewer",
    )
    parser.addoption(
        "--exported",
        action="store_true",
        help="simulate by exported models: `pytest --exported tests/mechanisms tests/stdlib`",
    )
    parser.addoption(
        "--screenshots",
        metavar="DIR",
        help="keep the pictures of the pages here (default: $PLANARC_SCREENSHOTS, else in "
        "pytest's temporary folder)",
    )


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "usual: what exported models do not do as other runs do")
    if config.getoption("--exported"):
        _run_exported()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("--exported"):
        for item in items:
            if item.get_closest_marker("usual"):
                item.add_marker(pytest.mark.skip(reason="exported models do not do this"))


def _run_exported() -> None:
    """Let the one door to a run lead to exported models, before anyone else knows it."""
    from planarc import compiler

    usual = compiler.run

    def run(compiled: Any, options: Any, clock: Any = None, progress: Any = None,
            kernel: Any = None) -> Any:  # fmt: skip
        plain = options.fixed_step is options.contact is None and options.solver is Solver.AUTO
        native = compiled.backend is options.backend is Backend.NATIVE
        if plain and native and (kernel is None or isinstance(kernel, Kept)):
            options = replace(options, solver=Solver.EXPORTED)
        return usual(compiled, options, clock, progress, kernel)

    compiler.run = run


@pytest.fixture(scope="session", autouse=True)
def _bytecode(request: pytest.FixtureRequest) -> None:
    """Keep bytecode in pytest's cache where Python must not keep it beside modules: else each
    process that a test starts compiles all modules anew."""
    kept = getattr(request.config, "cache", None)  # none with `-p no:cacheprovider`
    if kept is not None and os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
        os.environ["PYTHONPYCACHEPREFIX"] = str(kept.mkdir("bytecode"))


@pytest.fixture
def steps_of() -> Callable[[Callable[[], object]], int]:
    """`steps_of(work)`: how many functions are called in a work. A measure of its cost that
    is the same on every machine, whatever else runs there."""

    def measured(work: Callable[[], object]) -> int:
        count = 0

        def notice(_frame: object, event: str, _argument: object) -> None:
            nonlocal count
            count += event in ("call", "c_call")

        sys.setprofile(notice)
        try:
            work()
        finally:
            sys.setprofile(None)
        return count

    return measured


@pytest.fixture
def hang(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """`hang()` never returns, in a process of a crew. The limit of the crew has passed as soon
    as nothing but such jobs is under way: no clock is asked."""
    folder = tmp_path / "hanging"
    folder.mkdir()
    waited, clock = processes.wait, [0.0]

    def is_alive(process: str) -> bool:
        try:
            os.kill(int(process), 0)
        except OSError:
            return False
        return True

    def wait(connections: list[Any], patience: float) -> list[Any]:
        while not (ready := waited(connections, 0.02)):
            if len(connections) == sum(is_alive(p.name) for p in folder.iterdir()):
                clock[0] += patience + 1e-3
                return []
        return ready

    def hang() -> None:
        (folder / str(os.getpid())).touch()
        while True:
            time.sleep(PATIENCE)

    monkeypatch.setattr(processes, "wait", wait)
    monkeypatch.setattr(processes, "monotonic", lambda: clock[0])
    return hang


@pytest.fixture
def golden(request: pytest.FixtureRequest) -> Callable[[str, str], None]:
    """`golden("flat/pendulum.txt", text)` compares with the file, or rewrites it."""
    update = request.config.getoption("--update-golden")

    def check(name: str, text: str) -> None:
        path = GOLDEN / name
        if update:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8", newline="\n")
        assert path.exists(), f"{name} is missing; run pytest with --update-golden and read it"
        assert text == path.read_text(encoding="utf-8")

    return check
