"""What all tests share: golden files, shown with input and output together."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

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
        "--screenshots",
        metavar="DIR",
        help="keep the pictures of the pages here (default: $PLANARC_SCREENSHOTS, else in "
        "pytest's temporary folder)",
    )


@pytest.fixture(scope="session", autouse=True)
def _bytecode(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keep bytecode in the folder of the tests where Python must not keep it beside modules:
    else each process that a test starts compiles all modules anew."""
    if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
        os.environ["PYTHONPYCACHEPREFIX"] = str(tmp_path_factory.getbasetemp() / "bytecode")


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
