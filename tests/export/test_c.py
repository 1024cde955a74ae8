"""Models as C99: they compile without a warning, and run as planarc runs them."""

from __future__ import annotations

import csv
import io
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import planarc
from planarc.export.c.source import make_source
from planarc.export.wishes import Wishes
from tests.export.test_events import BALL, STICK_SLIP
from tests.export.test_fmu import compiled
from tests.export.test_wishes import FLYWHEEL
from tests.solve.start.test_redundant_joints import bars

ROOT = Path(__file__).parents[2]
COMPILER = shutil.which("cc")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="there is no C compiler")
SAMPLED = """
model Sampled "A controller that looks every tenth of a second"
  output Real x(start=1, fixed=true);
  discrete output Real u(start=0, fixed=true);
equation
  der(x) = u - 0.3*x + (if x > 0.5 then -1 else 0.2) + max(0, sin(3*time));
  when sample(0, 0.1) then
    u = 0.5*pre(u) - x;
  end when;
end Sampled;
"""

Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture
def run(tmp_path: Path) -> Run:
    """Compile a folder, as pedantically as a compiler can, and run what it makes."""

    def run(folder: Path) -> subprocess.CompletedProcess[str]:
        sources, made = sorted(folder.glob("*.c")), folder / "made"
        assert COMPILER is not None
        options = ("-std=c99", "-O1", "-Wall", "-Wextra", "-pedantic", "-Werror")
        told = subprocess.run(
            [COMPILER, *options, *sources, "-lm", "-o", made], capture_output=True, text=True
        )
        assert told.returncode == 0, told.stderr
        return subprocess.run([made], capture_output=True, text=True)

    return run


def misfit(model: planarc.Model, text: str, **options: object) -> float:
    """The largest difference to a run of planarc, as a part of the variable's range."""
    head, *rows = csv.reader(io.StringIO(text))
    found = np.array(rows, dtype=float)
    result = model.simulate(tolerance=1e-11, **options)
    last = np.searchsorted(result.time, found[:, 0] + 1e-12, side="right") - 1
    assert np.abs(result.time[last] - found[:, 0]).max() < 1e-9
    worst = 0.0
    for k, name in enumerate(head[1:], 1):
        values = np.asarray(result[name], dtype=float)
        size = max(np.ptp(values), 1e-9)
        worst = max(worst, float(np.abs(values[last] - found[:, k]).max() / size))
    return worst


@needs_compiler
@pytest.mark.parametrize(
    "name", ("pendulum", "four_bar", "crank_slider", "walking_leg", "cam_lift_off")
)
def test_a_run_is_the_one_of_planarc(run: Run, tmp_path: Path, name: str) -> None:
    model = planarc.load(str(ROOT / "examples" / f"{name}.pmo"))
    done = run(model.export_c(tmp_path / "c"))
    assert done.returncode == 0 and not done.stderr
    assert misfit(model, done.stdout) < 2e-6


@needs_compiler
@pytest.mark.parametrize("text", (BALL, STICK_SLIP, SAMPLED))
def test_events_are_those_of_planarc(run: Run, tmp_path: Path, text: str) -> None:
    model = planarc.load(text)
    done = run(model.export_c(tmp_path / "c"))
    assert done.returncode == 0 and not done.stderr
    assert misfit(model, done.stdout) < 1e-6


@needs_compiler
def test_redundant_joints_share_as_in_planarc(run: Run, tmp_path: Path) -> None:
    """Shares of forces hang on positions by large factors, as in the FMU of the same bars."""
    model = planarc.load(bars((0, 1, 2), centre=1.0), redundant="accept")
    done = run(model.export_c(tmp_path / "c", outputs=r"^low\d\.(phi|w)$|^high\d\.frame_a\.f"))
    assert done.returncode == 0 and not done.stderr
    assert misfit(model, done.stdout) < 3e-5


@needs_compiler
def test_implicit_steps_follow_a_hard_spring(run: Run, tmp_path: Path) -> None:
    text = """
    model Hard "x returns to cos(time) within a thousandth of a second"
      output Real x(start=0, fixed=true);
    equation
      der(x) = -1e6*(x - cos(time));
    end Hard;
    """
    done = run(planarc.load(text).export_c(tmp_path / "c", stiff=True))
    rows = np.array([row.split(",") for row in done.stdout.splitlines()[1:]], dtype=float)
    t, x = rows[1:].T
    # The slow solution, to the second order of the time constant.
    assert x == pytest.approx(np.cos(t) + 1e-6 * np.sin(t), abs=1e-7)


@needs_compiler
def test_a_program_sets_parameters_and_inputs(run: Run, tmp_path: Path) -> None:
    model = planarc.load(FLYWHEEL)
    folder = model.export_c(tmp_path / "c", inputs=["hinge.tau"])
    (folder / "main.c").write_text("""
    #include "model.h"
    #include <stdio.h>
    int main(void)
    {
        word *m = model_new();
        if (model_set(m, V_wheel_I, 0.5) != 0 || model_set(m, V_hinge_tau, -0.75) != 0) return 2;
        if (model_begin(m) != 0 || model_set(m, V_wheel_m, NAN) == 0) return 3;
        for (int k = 0; k <= 20; k++) {
            if (model_go(m, 0.1*k) != 0) return 4;
            printf("%.17g,%.17g\\n", model_value(m, V_time), model_value(m, V_hinge_phi));
        }
        free(m);
        return 0;
    }
    """)
    done = run(folder)
    assert done.returncode == 0
    t, phi = np.array([row.split(",") for row in done.stdout.splitlines()], dtype=float).T
    assert phi == pytest.approx(0.5 + 2 * t - 0.75 * t**2, abs=1e-8)


@needs_compiler
def test_an_assertion_ends_a_run_with_its_message(run: Run, tmp_path: Path) -> None:
    text = """
    model Late
      output Real x(start=0, fixed=true);
    equation
      der(x) = 1;
      assert(x < 0.5, "too \\"late\\"??/ 100 %d");
    end Late;
    """
    done = run(planarc.load(text).export_c(tmp_path / "c"))
    assert done.returncode == 1
    assert 'too "late"??/ 100 %d' in done.stderr
    assert 0.49 < float(done.stdout.splitlines()[-1].split(",")[1]) < 0.51


@needs_compiler
def test_nothing_is_allocated_while_it_runs(run: Run, tmp_path: Path) -> None:
    folder = planarc.load(str(ROOT / "examples" / "four_bar.pmo")).export_c(tmp_path / "c")
    for path in folder.glob("*.c"):
        path.write_text(re.sub(r"\bcalloc\(", "counted(", path.read_text()))
    header = folder / "model.h"
    header.write_text(header.read_text() + "\nvoid *counted(size_t n, size_t size);\n")
    (folder / "main.c").write_text("""
    #include "model.h"
    #include <stdio.h>
    static int count;
    void *counted(size_t n, size_t size) { count++; return calloc(n, size); }
    int main(void)
    {
        word *m = model_new();
        if (model_begin(m) != 0) return 2;
        int before = count;
        if (model_go(m, 10.0) != 0) return 3;
        printf("%d %d\\n", before, count - before);
        free(m);
        return 0;
    }
    """)
    asked, later = map(int, run(folder).stdout.split())
    assert asked > 0 and later == 0


def test_the_same_model_gives_the_same_files() -> None:
    assert make_source(compiled("pendulum"), Wishes()) == make_source(
        compiled("pendulum"), Wishes()
    )


def test_equations_have_the_names_of_variables() -> None:
    model = make_source(compiled("four_bar"), Wishes()).files["model.c"]
    assert "double crank_frame_b_r_1 = w[V_groundA_r_1].d + crank_r_0_1;" in model
