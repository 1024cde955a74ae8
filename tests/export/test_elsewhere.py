"""FMUs for Windows and for Linux on ARM64, run by emulators: the same motion as on this machine."""

from __future__ import annotations

import os
import shutil
import subprocess
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest

import planarc
from tests.export.fmus import EXAMPLES, runs_here

#: Platforms: a compiler of C, and what runs its programs.
SYSTEMS = {
    "aarch64-linux": (["aarch64-linux-gnu-gcc"], ["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"]),
    "x86_64-windows": (["x86_64-w64-mingw32-gcc"], ["wine"]),
}
#: A host: it takes equal steps and prints these variables at the end of each.
HOST = r"""
#ifdef _WIN32
#include <windows.h>
#define dlopen(name, how) LoadLibraryA(name)
#define dlsym(of, name) (void *)GetProcAddress(of, name)
#define dlerror() "it cannot be loaded"
#else
#include <dlfcn.h>
#endif
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
@pytest.mark.parametrize("platform", SYSTEMS)
@pytest.mark.parametrize(
    ("example", "stop", "near"),
    [("four_bar", 2.0, 1e-9), ("gripper", 1.0, 1e-6), ("cam_lift_off", 1.0, 1e-6)],
)
def test_it_runs_elsewhere(
    tmp_path: Path, platform: str, example: str, stop: float, near: float
) -> None:
    """Elementary functions are the system's, and differ in their last digit."""
    compiler, emulator = SYSTEMS[platform]
    if not all(shutil.which(program) for program, *_ in (compiler, emulator)):
        pytest.skip(f"nothing here runs programs of {platform}")
    path = tmp_path / "a.fmu"
    planarc.load(EXAMPLES / f"{example}.pmo").export_fmu(path, platforms=("x86_64-linux", platform))
    told = fmpy.read_model_description(str(path))
    shown = [v for v in told.modelVariables if v.causality == "output" and v.type == "Float64"]
    assert shown
    with zipfile.ZipFile(path) as archive:
        archive.extractall(tmp_path)
    (tmp_path / "host.c").write_text(HOST)
    subprocess.run([*compiler, "-o", "host", "host.c"], cwd=tmp_path, check=True)
    program = next(str(p) for p in (tmp_path / "host", tmp_path / "host.exe") if p.exists())
    (library,) = tmp_path.glob(f"binaries/{platform}/*")
    ran = subprocess.run(
        [*emulator, program, str(library.relative_to(tmp_path)), told.guid, "resources/",
         str(stop), str(STEPS), *(str(v.valueReference) for v in shown)],
        cwd=tmp_path, capture_output=True, text=True, timeout=300,
        env={**os.environ, "WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all",
             "WINEDLLOVERRIDES": "mscoree,mshtml="},
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
