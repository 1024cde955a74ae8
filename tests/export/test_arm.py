"""FMUs for Linux on ARM64, run by an emulator: the same motion as on this machine."""

from __future__ import annotations

import shutil
import subprocess
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest

import planarc
from tests.export.fmus import EXAMPLES, runs_here

COMPILER, EMULATOR = shutil.which("aarch64-linux-gnu-gcc"), shutil.which("qemu-aarch64")
#: A host: it takes equal steps and prints these variables at the end of each.
HOST = r"""
#include <dlfcn.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
typedef void (*Log)(void *, int, const char *, const char *);
static void told(void *to, int status, const char *kind, const char *text) {
  fprintf(stderr, "%d %s: %s\n", status, kind, text);
}
int main(int count, char **given) {
  void *of = dlopen(given[1], RTLD_NOW);
  if (!of) return fprintf(stderr, "%s\n", dlerror()), 9;
  void *(*instantiate)(const char *, const char *, const char *, bool, bool, bool, bool,
    const uint32_t *, size_t, void *, Log, void *) = dlsym(of, "fmi3InstantiateCoSimulation");
  int (*enter)(void *, bool, double, double, bool, double) =
    dlsym(of, "fmi3EnterInitializationMode");
  int (*leave)(void *) = dlsym(of, "fmi3ExitInitializationMode");
  int (*step)(void *, double, double, bool, bool *, bool *, bool *, double *) =
    dlsym(of, "fmi3DoStep");
  int (*get)(void *, const uint32_t *, size_t, double *, size_t) = dlsym(of, "fmi3GetFloat64");
  void *m = instantiate("a", given[2], given[3], false, true, false, false, 0, 0, 0, told, 0);
  double stop = atof(given[4]), h = stop / atoi(given[5]), last;
  bool event, over, early;
  if (!m || enter(m, false, 0.0, 0.0, true, stop) || leave(m)) return 1;
  for (int i = 0; i < atoi(given[5]); i++) {
    if (step(m, i * h, h, true, &event, &over, &early, &last)) return 2;
    for (int k = 6; k < count; k++) {
      uint32_t reference = (uint32_t)atol(given[k]);
      double value;
      if (get(m, &reference, 1, &value, 1)) return 3;
      printf("%.17g ", value);
    }
    printf("\n");
  }
  return 0;
}
"""
STEPS = 20


@runs_here
@pytest.mark.skipif(not (COMPILER and EMULATOR), reason="there is no emulator of ARM64 here")
@pytest.mark.parametrize(
    ("example", "stop", "near"),
    [("four_bar", 2.0, 1e-9), ("gripper", 1.0, 1e-6), ("cam_lift_off", 1.0, 1e-6)],
)
def test_arm_runs_it(tmp_path: Path, example: str, stop: float, near: float) -> None:
    """Elementary functions are the system's, and differ in their last digit."""
    path = tmp_path / "a.fmu"
    platforms = ("x86_64-linux", "aarch64-linux")
    planarc.load(EXAMPLES / f"{example}.pmo").export_fmu(path, platforms=platforms)
    told = fmpy.read_model_description(str(path))
    shown = [v for v in told.modelVariables if v.causality == "output" and v.type == "Float64"]
    assert shown
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path)
    (tmp_path / "host.c").write_text(HOST)
    subprocess.run([str(COMPILER), "-o", "host", "host.c", "-ldl"], cwd=tmp_path, check=True)
    library = next(tmp_path.glob("binaries/aarch64-linux/*.so"))
    ran = subprocess.run(
        [str(EMULATOR), "-L", "/usr/aarch64-linux-gnu", "./host", str(library),
         told.guid, f"{tmp_path / 'resources'}/", str(stop), str(STEPS),
         *(str(v.valueReference) for v in shown)],
        cwd=tmp_path, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    there = np.array([[float(n) for n in line.split()] for line in ran.stdout.splitlines()])
    here = fmpy.simulate_fmu(
        str(path), fmi_type="CoSimulation", stop_time=stop, output_interval=stop / STEPS,
        step_size=stop / STEPS, output=[v.name for v in shown],
    )  # fmt: skip
    for k, v in enumerate(shown):
        size = max(1.0, float(np.ptp(here[v.name])))
        assert there[:, k] == pytest.approx(here[v.name][1:], abs=near * size), v.name
