"""Exported crowds: the same steps with the same bits, in FMUs, in C, and in a page."""

from __future__ import annotations

import csv
import ctypes
import platform
import re
import shutil
import subprocess
import zipfile
from functools import cache
from pathlib import Path
from xml.etree import ElementTree as Xml

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

import planarc
from planarc.core.diagnostic import UsageError
from planarc.export.c.source import make_source
from planarc.export.fmi.three import functions
from planarc.export.fmu import make_fmu
from planarc.export.image import take_image
from planarc.export.module import write_whole
from planarc.export.page.module import make_module
from planarc.export.page.page import make_page
from planarc.export.shared import CALLED
from planarc.export.wishes import Wishes
from tests.export.fmus import HERE, runs_here, written
from tests.export.test_wasm import needs_node, of_node

FREE = (
    "each fixed=true), v(start={{{}, {}}}, each fixed=true), phi(start={}, fixed=true), w(start={}"
)
BODY = "  Parts.Body {}(m={}, I={}, r(start={{{}, {}}}, " + FREE + ", fixed=true));\n"


def bodies(*given: tuple[object, ...]) -> str:
    return "".join(BODY.format(*g) for g in given)


#: Three circles and a bar in a box.
BOX = (
    "model Box\n  import PlanarMultiBody.*;\n  inner World world;\n"
    + bodies(
        ("a", 1, 0.002, 0.1, 0.3, 0.5, 0, 0, 0),
        ("b", 2, 0.004, 0.32, 0.25, -0.3, -1, 0.3, 2),
        ("c", 1, 0.002, 0.2, 0.5, 0, -1, 0, -1),
        ("d", 1.5, 0.01, 0.25, 0.8, 0.1, 0, 1.1, 3),
    )
    + """  Contacts.Crowd crowd(n=4, R={0.05, 0.06, 0.05, 0.04}, length={0, 0, 0, 0.2}, e=0.4,
    mu=0.3,
    walls=[0, 0, 0.5, 0; 0, 0, 0, 1; 0.5, 0, 0.5, 1]);
equation
  connect(a.frame_a, crowd.frame_a[1]);
  connect(b.frame_a, crowd.frame_a[2]);
  connect(c.frame_a, crowd.frame_a[3]);
  connect(d.frame_a, crowd.frame_a[4]);
  connect(world.frame_b, crowd.frame_b);
  annotation(experiment(StopTime=1, Interval=0.01));
end Box;
"""
)
#: A slider-crank whose slider meets a stop and a body that lies on the ground by a Contact.
LOOP = (
    "model Loop\n  import PlanarMultiBody.*;\n  inner World world;\n"
    + bodies(("ball", 1, 0.002, 1.05, -0.9, 0.2, 0, 0, 1))
    + """  Joints.Revolute crank(phi(start=1, fixed=true), w(start=-2, fixed=true));
  Parts.BodyShape arm(m=1, r={0.3, 0}, r_CM={0.15, 0}, I=0.01);
  Parts.BodyShape rod(m=1, r={0.8, 0}, r_CM={0.4, 0}, I=0.05);
  Joints.Revolute elbow;
  Joints.Revolute pin;
  Joints.Prismatic slide(n={1, 0});
  Parts.Body slider(m=2, I=0.01);
  Contacts.Crowd crowd(n=2, R={0.1, 0.1}, e=0.5, mu=0.2, walls=[1.15, -2, 1.15, 2]);
  Contacts.Contact contact(redeclare Contacts.Circle contour1(R=0.1), e=0.3, mu=0.2);
  Parts.Fixed ground(r={0, -1});
equation
  connect(world.frame_b, crank.frame_a);
  connect(crank.frame_b, arm.frame_a);
  connect(arm.frame_b, elbow.frame_a);
  connect(elbow.frame_b, rod.frame_a);
  connect(rod.frame_b, pin.frame_a);
  connect(pin.frame_b, slide.frame_b);
  connect(world.frame_b, slide.frame_a);
  connect(slider.frame_a, slide.frame_b);
  connect(slide.frame_b, crowd.frame_a[1]);
  connect(ball.frame_a, crowd.frame_a[2]);
  connect(ball.frame_a, contact.frame_a);
  connect(ground.frame_b, contact.frame_b);
  connect(world.frame_b, crowd.frame_b);
  annotation(experiment(StopTime=1, Interval=0.01));
end Loop;
"""
)
#: Two crowds, a drum that turns, a sampler and a relation that change forces, an event that ends.
DRUM = (
    "model Drum\n  import PlanarMultiBody.*;\n  inner World world;\n"
    + bodies(
        ("a", 1, 0.002, 0.1, 0.1, 0, 0, 0, 0),
        ("b", 1, 0.002, -0.15, 0, 0, 0, 0, 0),
        ("p", 1, 0.002, 3, 1, -1, 0, 0, 0),
        ("q", 1, 0.002, 2, 1.01, 1, 0, 0, 0),
    )
    + """  Joints.Revolute hub(phi(fixed=true), w(start=3, fixed=true));
  Parts.Body rim(m=1, I=0.2);
  Contacts.Crowd crowd(n=2, R={0.05, 0.05}, mu=0.5,
    walls=[-0.3, -0.3, 0.3, -0.3; 0.3, -0.3, 0.3, 0.3; 0.3, 0.3, -0.3, 0.3; -0.3, 0.3, -0.3, -0.3]);
  Contacts.Crowd other(n=2, R={0.1, 0.1}, e=1, R_walls=0.01, walls=[0, 0, 5, 0]);
  Forces.WorldForce push;
  discrete Real level(start=0, fixed=true);
  output Real height = p.r[2];
  output Integer passed(start=0, fixed=true);
equation
  when sample(0.105, 0.2) then
    level = pre(level) + 1;
  end when;
  when p.r[2] < 0.5 then
    passed = pre(passed) + 1;
  end when;
  push.force = {level + (if a.r[1] > 0.05 then 1 else 0), 0};
  connect(push.frame_b, a.frame_a);
  connect(world.frame_b, hub.frame_a);
  connect(hub.frame_b, rim.frame_a);
  connect(hub.frame_b, crowd.frame_b);
  connect(a.frame_a, crowd.frame_a[1]);
  connect(b.frame_a, crowd.frame_a[2]);
  connect(p.frame_a, other.frame_a[1]);
  connect(q.frame_a, other.frame_a[2]);
  connect(world.frame_b, other.frame_b);
  annotation(experiment(StopTime=1, Interval=0.01));
end Drum;
"""
)
#: A bar that is pulled as a circle was a while ago.
LATE = BOX.replace("Box", "Late").replace(
    "equation\n",
    """  Forces.WorldForce push;
  Real pull = 3*sin(10*time) - 5*a.v[2];
  output Real late = delay(pull, 0.0125);
equation
  push.force = {late, 0};
  connect(push.frame_b, d.frame_a);
""",
)
MODELS = {"Box": BOX, "Loop": LOOP, "Drum": DRUM, "Late": LATE}
#: A ball in a box, with a force from outside, or with the same one by itself.
FED = (
    "model Fed\n  import PlanarMultiBody.*;\n  inner World world;\n"
    + bodies(("a", 1, 0.002, 0.3, 0.06, 0, 0, 0, 0))
    + """  Contacts.Crowd crowd(n=1, R={0.05}, e=0.5, mu=0.3, walls=[0, 0, 1, 0; 1, 0, 1, 1]);
  Forces.WorldForce push;
  $
equation
  push.force = {u, 0};
  connect(push.frame_b, a.frame_a);
  connect(a.frame_a, crowd.frame_a[1]);
  connect(world.frame_b, crowd.frame_b);
  annotation(experiment(StopTime=1, Interval=0.01));
end Fed;
"""
)


@cache
def loaded(name: str) -> planarc.Model:
    return planarc.load(MODELS[name])


@cache
def by_planarc(name: str, interval: float = 0.01) -> planarc.Result:
    return loaded(name).simulate(interval=interval)


def archive(folder: Path, name: str, version: int = 3) -> Path:
    return written(folder / f"crowd_{name}{version}.fmu", loaded(name).compiled(), version)


#: Sines and cosines of a loop differ from those of the platform's library in their last digit:
#: 1e-16 beside the least range that `misfit` knows.
ROUNDING = {"Loop": 1e-9}


def misfit(result: planarc.Result, found: dict[str, np.ndarray], times: np.ndarray) -> float:
    """The largest difference, as a part of each range, behind events where there are some."""
    rows = [np.flatnonzero(np.abs(result.time - t) < 1e-9)[-1] for t in times]
    worst = 0.0
    for name, values in found.items():
        wanted = result[name]
        size = max(np.ptp(wanted), 1e-6)
        worst = max(worst, float(np.abs(wanted[rows] - values).max() / size))
    return worst


def of_table(table: np.ndarray) -> tuple[dict[str, np.ndarray], np.ndarray]:
    return {n: table[n] for n in table.dtype.names[1:]}, table["time"]


def outputs_of(name: str) -> list[str]:
    places = [c.name for c in loaded(name).compiled().program.columns if not c.protected]
    shown = re.compile(r"^\w+\.(r\[\d\]|v\[\d\]|phi|w)$|^\w+\.f(_b)?\[[\d,]+\]$|^contact\.f_n")
    return [n for n in places if shown.search(n)]


def tabled(folder: Path, name: str, version: int = 3, **more: object) -> np.ndarray:
    options = {"output_interval": 0.01, "record_events": False, "stop_time": 1.0} | more
    path = archive(folder, name, version)
    known = {v.name for v in fmpy.read_model_description(path).modelVariables}
    names = [n for n in outputs_of(name) if n in known]
    assert len(names) > 12
    return fmpy.simulate_fmu(path, output=names, **options)


@pytest.mark.parametrize(("name", "version"), [(n, 3) for n in MODELS] + [("Box", 2)])
def test_fmpy_has_nothing_to_say(folder: Path, name: str, version: int) -> None:
    assert validate_fmu(str(archive(folder, name, version))) == []


@runs_here
@pytest.mark.parametrize("name", MODELS)
def test_a_run_has_the_digits_of_planarc(folder: Path, name: str) -> None:
    found = misfit(by_planarc(name), *of_table(tabled(folder, name)))
    assert found < ROUNDING.get(name, 1e-12)


@pytest.mark.skipif(platform.machine() != "x86_64" or not HERE, reason="not of FMI 2")
def test_both_versions_run_alike(folder: Path) -> None:
    two, three = (tabled(folder, "Box", version) for version in (2, 3))
    assert all((two[n] == three[n]).all() for n in two.dtype.names)


@runs_here
@pytest.mark.parametrize("interval", (0.0004, 0.0037, 0.25))
def test_steps_are_those_of_planarc_wherever_a_host_looks(folder: Path, interval: float) -> None:
    """Steps of 1 ms."""
    table = tabled(folder, "Box", output_interval=interval)
    assert misfit(by_planarc("Box", interval), *of_table(table)) < 1e-12


@runs_here
@pytest.mark.parametrize("more", ({}, {"use_event_mode": True}))
def test_events_are_handed_over(folder: Path, more: dict[str, bool]) -> None:
    table = tabled(folder, "Drum", record_events=True, early_return_allowed=True, **more)
    rows = np.abs(table["time"] * 100 - np.round(table["time"] * 100)) < 1e-7
    found = {n: table[n][rows] for n in table.dtype.names[1:]}
    assert misfit(by_planarc("Drum"), found, table["time"][rows]) < 1e-6
    for t in (0.105, 0.305):
        assert np.abs(table["time"] - t).min() < 1e-9


@pytest.mark.parametrize("version", (2, 3))
def test_it_is_for_co_simulation_alone(folder: Path, version: int) -> None:
    path = archive(folder, "Box", version)
    with zipfile.ZipFile(path) as files:
        root = Xml.fromstring(files.read("modelDescription.xml"))
        page = files.read("documentation/index.html").decode()
    assert root.find("ModelExchange") is None and root.find("CoSimulation") is not None
    assert not [e for e in root.iter() if e.tag in ("Derivatives", "ContinuousStateDerivative")]
    assert "for co-simulation alone" in page and "_step" in page


class Slave:
    """An instance for co-simulation, and what its logger was told."""

    def __init__(self, path: Path, **starts: float) -> None:
        description = fmpy.read_model_description(path)
        self.names = {v.name: v.valueReference for v in description.modelVariables}
        self.told: list[str] = []
        self.fmu = FMU3Slave(guid=description.guid, unzipDirectory=fmpy.extract(path),
                             modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip
        self.fmu.instantiate(logMessage=lambda *given: self.told.append(given[-1].decode()))
        for name, value in starts.items():
            self.set(name.replace("__", "."), value)

    def begin(self) -> Slave:
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        return self

    def set(self, name: str, value: float) -> None:
        self.fmu.setFloat64([self.names[name]], [value])

    def values(self, *names: str) -> list[float]:
        return [self.fmu.getFloat64([self.names[n]])[0] for n in names]

    def go(self, first: int, last: int, h: float) -> list[list[float]]:
        """Steps, and some values behind each."""
        rows = []
        for k in range(first, last):
            self.fmu.doStep(k * h, h)
            rows.append(self.values("a.r[1]", "d.phi", "d.w", "crowd.f_b[2]", "crowd.t_b"))
        return rows


@runs_here
def test_a_state_that_was_saved_goes_on_as_before(folder: Path) -> None:
    """In the midst of a step, with impulses that the next one begins from; in another instance,
    too."""
    one, other = (Slave(archive(folder, "Box")).begin() for _ in range(2))
    one.go(0, 60, 0.0073)
    state = one.fmu.getFMUState()
    data = one.fmu.serializeFMUState(state)
    assert one.values("crowd.f_b[2]")[0] != 0
    ahead = one.go(60, 120, 0.0073)
    one.fmu.setFMUState(state)
    assert one.go(60, 120, 0.0073) == ahead
    other.go(0, 13, 0.0073)
    other.fmu.setFMUState(other.fmu.deserializeFMUState(data))
    assert other.go(60, 120, 0.0073) == ahead


@runs_here
def test_instances_do_not_know_of_each_other(folder: Path) -> None:
    path = archive(folder, "Box")
    alone = [Slave(path, crowd__e=e).begin().go(0, 50, 0.01) for e in (0.0, 0.9)]
    both = [Slave(path, crowd__e=e).begin() for e in (0.0, 0.9)]
    rows = [[one.go(k, k + 1, 0.01)[0] for one in both] for k in range(50)]
    assert [[row[i] for row in rows] for i in (0, 1)] == alone
    assert alone[0] != alone[1]


@runs_here
def test_a_new_instance_begins_anew(folder: Path) -> None:
    slave = Slave(archive(folder, "Box")).begin()
    first = slave.go(0, 70, 0.01)
    slave.fmu.reset()
    assert slave.begin().go(0, 70, 0.01) == first


@runs_here
def test_the_length_of_steps_and_parameters_may_be_set(folder: Path) -> None:
    given = {"_step": 2.5e-3, "crowd.e": 0.1, "a.m": 3.0, "a.v[1]": -0.4}
    table = tabled(folder, "Box", start_values=given)
    wanted = loaded("Box").simulate(
        fixed_step=2.5e-3, parameters={"crowd.e": 0.1, "a.m": 3.0}, start={"a.v[1]": -0.4}
    )
    assert misfit(wanted, *of_table(table)) < 1e-12
    slave = Slave(archive(folder, "Box"))
    with pytest.raises(FMICallException):
        slave.set("_step", 0.0)
    assert "no length" in slave.told[-1]
    slave.begin()
    with pytest.raises(FMICallException):
        slave.set("_step", 1e-3)
    assert "cannot be set now" in slave.told[-1]


@runs_here
def test_bodies_that_begin_in_each_other_are_named(folder: Path) -> None:
    slave = Slave(archive(folder, "Box"), **{"b__r[1]": 0.17, "b__r[2]": 0.3})
    with pytest.raises(FMICallException):
        slave.begin()
    assert "`a.frame_a` and `b.frame_a` overlap by 0.04 m in `crowd` at t = 0 s" in slave.told[-1]
    slave = Slave(archive(folder, "Box"), **{"a__r[1]": 0.04})
    with pytest.raises(FMICallException):
        slave.begin()
    assert "`a.frame_a` and a wall overlap by 0.01 m in `crowd`" in slave.told[-1]
    slave = Slave(archive(folder, "Loop"), **{"ball__r[2]": -0.95})
    with pytest.raises(FMICallException):
        slave.begin()
    assert "overlap by 0.05 m" in slave.told[-1] and "`contact`" in slave.told[-1]


@runs_here
def test_what_is_not_offered_says_so(folder: Path) -> None:
    slave = Slave(archive(folder, "Box")).begin()
    for name in ("fmi3EnterContinuousTimeMode", "fmi3GetEventIndicators"):
        call = getattr(slave.fmu.dll, name)
        assert call(ctypes.c_void_p(slave.fmu.component), None, ctypes.c_size_t(0)) == 3
        assert slave.told[-1] == f"{name} is not offered by this model"
    with pytest.raises(FMICallException):
        slave.fmu.doStep(0.0, 0.0)
    assert "length of the step" in slave.told[-1]


@runs_here
def test_a_force_from_outside_counts_from_where_it_is_set(folder: Path, tmp_path: Path) -> None:
    """The same as one that the model changes by itself then: between steps, and within one."""
    path = tmp_path / "fed.fmu"
    written(path, planarc.load(FED.replace("$", "input Real u(start=0);")).compiled(), 3)
    for t in (0.3, 0.3004):
        own = f"Real u=if time < {t} then 0 else 4;"
        result = planarc.load(FED.replace("$", own)).simulate(fixed_step=1e-3)
        slave = Slave(path).begin()
        slave.fmu.doStep(0.0, t)
        slave.set("u", 4.0)
        slave.fmu.doStep(t, 1.0 - t)
        names = "a.r[1]", "a.v[1]", "a.w", "crowd.f_b[1]"
        assert slave.values(*names) == pytest.approx([result[n][-1] for n in names], abs=1e-9)
        assert abs(result["a.w"][-1]) > 1


@runs_here
@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler here")
@pytest.mark.parametrize("name", MODELS)
def test_c_has_the_digits_of_planarc(tmp_path: Path, name: str) -> None:
    wishes = Wishes(outputs=re.compile("|".join(map(re.escape, outputs_of(name)))))
    for file, text in make_source(loaded(name).compiled(), wishes).files.items():
        (tmp_path / file).write_text(text, "utf-8")
    command = "cc -std=c99 -O1 -ffp-contract=off -Wall -Wextra -Werror *.c -lm -o model"
    subprocess.run(command, shell=True, cwd=tmp_path, check=True)
    done = subprocess.run(["./model"], cwd=tmp_path, capture_output=True, text=True, check=True)
    head, *rows = csv.reader(done.stdout.splitlines())
    data = dict(zip(head, np.array(rows, float).T, strict=True))
    found = {n: data[n] for n in outputs_of(name) if n in data}
    assert len(found) > 12
    assert misfit(by_planarc(name), found, data["time"]) < ROUNDING.get(name, 1e-12)


@needs_node
@pytest.mark.parametrize("name", MODELS)
def test_a_page_has_the_digits_of_planarc(tmp_path: Path, name: str) -> None:
    compiled = loaded(name).compiled()
    columns = {c.name: c for c in compiled.program.columns}
    shown = [n for n in outputs_of(name) if not columns[n].constant]
    times = by_planarc("Box").time.tolist()
    slots = [columns[n].slot for n in shown]
    (told,) = of_node(tmp_path, make_module(compiled).code, slots, ([], times))
    found = {
        n: columns[n].sign * np.array(values)
        for n, values in zip(shown, told["columns"], strict=True)
    }
    rows = [int(np.flatnonzero(np.abs(np.array([*told["time"].values()]) - t) < 1e-9)[-1])
            for t in times]  # fmt: skip
    found = {n: values[rows] for n, values in found.items()}
    assert misfit(by_planarc(name), found, np.array(times)) < 1e-9


def test_a_page_tells_of_bodies_that_overlap() -> None:
    model = loaded("Box")
    page = make_page(model.compiled(), by_planarc("Box").rows)
    assert "bodies overlap in `crowd`" in page.text and page.fields > 10


def test_functions_have_names_of_their_own() -> None:
    compiled = loaded("Late").compiled()
    written = write_whole(compiled.program, take_image(compiled), functions(True, True), "", 1e-8)
    names = re.findall(r"^define [^@]*@(\w+)\(", written.shared.text(), re.MULTILINE)
    assert {"pc_past"} <= written.shared.called <= CALLED
    assert len(names) > 100 and len(set(names)) == len(names)


def test_implicit_steps_are_refused() -> None:
    for export in (make_fmu, make_source):
        with pytest.raises(UsageError) as refused:
            export(loaded("Box").compiled(), Wishes(stiff=True))
        assert refused.value.diagnostics[0].code == "R483"


def test_five_platforms_take_little_room() -> None:
    box = planarc.load("PlanarMultiBody.Examples.Contacts.FullBox").compiled()
    assert len(make_fmu(box, Wishes()).data) < 190_000
