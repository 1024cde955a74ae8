"""A model as WebAssembly: linked here, run by node, beside the same functions as machine code."""

from __future__ import annotations

import ctypes
import json
import platform
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from planarc.compiled import Compiled
from planarc.compiler import compile_model, run
from planarc.core.arrays import Vector
from planarc.core.options import RunOptions
from planarc.export.fmu import PLATFORMS, make_library
from planarc.export.image import take_image
from planarc.export.link.wasm import write_module
from planarc.export.module import write_whole
from planarc.export.objects import compile_library, compile_wasm
from planarc.export.page.entries import functions
from planarc.export.page.module import make_module
from planarc.export.wishes import tolerance_of
from planarc.request.request import Request

ROOT = Path(__file__).parents[2]
ENGINE = ROOT / "planarc" / "export" / "page" / "engine.js"
NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="there is no node here")

#: Runs the engine as a page does: [values, times] from standard input, rows to standard output.
DRIVER = """
const { readFileSync } = require("fs");
const [engine, module] = process.argv.slice(1);
const planarc = {};
eval(readFileSync(engine, "utf-8"));
const { slots, orders } = JSON.parse(readFileSync(0, "utf-8"));
(async () => {
  const model = await planarc.createEngine(readFileSync(module), slots);
  const told = [];
  for (const { values, times } of orders) {
    const run = await model.run(values, times);
    const columns = slots.map((_, k) => Array.from(run.column(k)));
    told.push({ ...run, columns });
  }
  console.log(JSON.stringify(told));
})();
"""


@cache
def compiled(name: str) -> Compiled:
    return compile_model(Request(ROOT / "examples" / f"{name}.pmo"))


def of_node(
    folder: Path, code: bytes, slots: list[int], *orders: tuple[object, object]
) -> list[dict[str, object]]:
    """What the engine gives for each order (values, times)."""
    (folder / "m.wasm").write_bytes(code)
    text = json.dumps({"slots": slots, "orders": [{"values": o[0], "times": o[1]} for o in orders]})
    done = subprocess.run(
        [str(NODE), "-e", DRIVER, str(ENGINE), str(folder / "m.wasm")],
        input=text, capture_output=True, text=True, check=True,
    )  # fmt: skip
    found: list[dict[str, object]] = json.loads(done.stdout)
    return found


def as_machine_code(folder: Path, model: Compiled, slots: list[int], times: list[float]) -> Vector:
    """The same functions, run in this process."""
    kind, entries = PLATFORMS[f"{platform.machine()}-linux"], functions()
    objects = compile_library(
        model.program, take_image(model), entries, "", tolerance_of(model.program), kind.triple
    )
    (folder / "m.so").write_bytes(make_library(kind, objects, "m.so", entries.names))
    library = ctypes.CDLL(str(folder / "m.so"))
    library.page_new.restype = ctypes.c_void_p
    block = ctypes.c_void_p(library.page_new())
    assert library.page_begin(block) == 0
    rows, wanted = np.zeros(len(times) * len(slots) + 1), np.array(slots, dtype=np.int64)
    when, end = np.array(times), ctypes.c_int(len(times))
    done = library.page_rows(
        block, ctypes.c_void_p(when.ctypes.data), ctypes.c_int(0), end,
        ctypes.c_void_p(wanted.ctypes.data), ctypes.c_int(len(slots)),
        ctypes.c_void_p(rows.ctypes.data),
    )  # fmt: skip
    assert done == len(times)
    return rows[:-1].reshape(len(times), len(slots)).T


@needs_node
@pytest.mark.skipif(sys.platform != "linux", reason="a library for Linux")
@pytest.mark.parametrize("name", ["four_bar", "pendulum", "crank_slider", "double_pendulum"])
def test_digits_are_those_of_machine_code(name: str, tmp_path: Path) -> None:
    model = compiled(name)
    slots = sorted({c.slot for c in model.program.columns if not c.constant})
    times = [*np.linspace(0.0, 2.0, 101)]
    (told,) = of_node(tmp_path, make_module(model).code, slots, ([], times))
    native = as_machine_code(tmp_path, model, slots, times)
    size = np.abs(native).max(axis=1, keepdims=True)
    worst = np.abs(np.array(told["columns"]) - native) / np.maximum(size, 1e-3)
    assert worst.max() < 1e-9


@needs_node
def test_another_crank_gives_what_planarc_gives(tmp_path: Path) -> None:
    model = compiled("four_bar")
    crank = next(p for p in model.program.parameter_slots if p.name == "crank.r[1]")
    column = next(c for c in model.program.columns if c.name == "revC.phi")
    wanted = run(model, RunOptions(stop=1.0, tolerance=1e-11, values={crank.name: 0.3}))
    times = [float(t) for t in wanted.time]
    first, changed, again = of_node(
        tmp_path, make_module(model).code, [column.slot],
        ([], times), ([(crank.slot, 0.3)], times), ([], times),
    )  # fmt: skip
    (phi,) = np.array(changed["columns"])
    assert np.abs(column.sign * phi - wanted["revC.phi"]).max() < 1e-7
    assert first == again != changed


@needs_node
def test_loops_are_closed_from_row_to_row(tmp_path: Path) -> None:
    """Where a drive turns evenly, steps could be far longer than a loop can be followed."""
    model = compiled("walking_leg")
    wanted = run(model, RunOptions(tolerance=1e-10))
    column = next(c for c in model.program.columns if c.name == "ankle.phi")
    times = [float(t) for t in wanted.time]
    (told,) = of_node(tmp_path, make_module(model).code, [column.slot], ([], times))
    assert told["rows"] == len(times)
    (phi,) = np.array(told["columns"])
    assert np.abs(column.sign * phi - wanted["ankle.phi"]).max() < 1e-7


@needs_node
def test_a_mass_bounces_where_it_does_in_planarc(tmp_path: Path) -> None:
    """By the law of free fall: the first bounce is after sqrt(2*h/g), each further one after
    sqrt(0.64) = 0.8 of the time of the one before."""
    (tmp_path / "ball.pmo").write_text(
        """
model Ball
  Real h(start=1, fixed=true), v(start=0, fixed=true);
  Integer n(start=0, fixed=true);
equation
  der(h) = v;
  der(v) = -9.81;
  when h < 0 then
    reinit(v, -0.8*pre(v));
    n = pre(n) + 1;
  end when;
end Ball;
"""
    )
    model = compile_model(Request(tmp_path / "ball.pmo"))
    slots = {c.name: c.slot for c in model.program.columns}
    first = (2 / 9.81) ** 0.5
    bounces = first * np.array([1.0, 2.6, 3.88])
    times = sorted(float(t) for b in bounces for t in (b - 1e-6, b + 1e-6))
    (told,) = of_node(
        tmp_path, make_module(model).code, [slots["n"], slots["v"]], ([], [0.0, *times])
    )
    count, speed = np.array(told["columns"])
    assert count.tolist() == [0, 0, 1, 1, 2, 2, 3]
    down = -9.81 * first * np.array([1.0, 0.8, 0.64])
    assert np.abs(speed[1::2] - down).max() < 1e-4
    assert np.abs(speed[2::2] + 0.8 * down).max() < 1e-4


@needs_node
def test_what_cannot_be_is_told(tmp_path: Path) -> None:
    model = compiled("four_bar")
    slots = {p.name: p.slot for p in model.program.parameter_slots}
    column = next(c for c in model.program.columns if c.name == "revC.phi")
    long, computed = of_node(
        tmp_path, make_module(model).code, [column.slot],
        ([(slots["crank.r[1]"], 30.0)], [0.0, 1.0]), ([(column.slot, 1.0)], [0.0, 1.0]),
    )  # fmt: skip
    assert not long["begun"] and long["rows"] == 0
    assert computed["refused"] == column.slot


def test_the_same_model_gives_the_same_bytes() -> None:
    one, two = (make_module(compiled("four_bar")).code for _ in range(2))
    assert one == two and one[:8] == b"\0asm\1\0\0\0"
    assert len(one) < 45_000


def test_a_function_that_no_object_has_is_imported() -> None:
    """And what nothing reaches is left out."""
    model, entries = compiled("pendulum"), functions()
    objects = compile_wasm(
        write_whole(model.program, take_image(model), entries, "", 1e-8, None, False)
    )
    small, whole = (write_module(objects, names) for names in (entries.names[:1], entries.names))
    assert b"calloc" in small and b"\3sin" not in small
    assert b"\3sin" in whole and len(small) < len(whole)
