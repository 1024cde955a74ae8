"""The model description says what a host needs to know: units, what is discrete, what depends on
what; what it could not say rightly is refused."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as Xml
from zipfile import ZipFile

import fmpy
import pytest
from fmpy.validation import validate_fmu

import planarc
from planarc.core.diagnostic import PlanarcError
from tests.export.fmus import EXAMPLES, WAYS, runs_here, simulate

VERSIONS = (2, 3)


def described(path: Path) -> Xml.Element:
    with ZipFile(path) as archive:
        return Xml.fromstring(archive.read("modelDescription.xml"))


def exported(folder: Path, text: str, version: int = 3) -> Path:
    path = folder / f"Model{version}.fmu"
    planarc.load(text).export_fmu(path, fmi=version)
    assert validate_fmu(str(path)) == []
    return path


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(
    ("unit", "base"),
    [
        ("mm", {"m": "1", "factor": "0.001"}),
        ("g", {"kg": "1", "factor": "0.001"}),
        ("deg", {"rad": "1", "factor": "0.017453292519943295"}),
        ("degC", {"K": "1", "offset": "273.15"}),
        ("km/h", {"m": "1", "s": "-1", "factor": "0.2777777777777778"}),
        ("N.m", {"kg": "1", "m": "2", "s": "-2"}),
    ],
)
def test_units_tell_their_scale(
    tmp_path: Path, unit: str, base: dict[str, str], version: int
) -> None:
    text = f'model M parameter Real p(unit="{unit}")=1; Real x = p*time; end M;'
    root = described(exported(tmp_path, text, version))
    (found,) = (u for u in root.iter("Unit") if u.get("name") == unit)
    given = found.find("BaseUnit")
    assert given is not None and dict(given.items()) == base


def test_temperatures_are_shown_in_degrees(tmp_path: Path) -> None:
    text = 'model M parameter Real T(unit="K", displayUnit="degC")=300; Real x = T*time; end M;'
    (shown,) = described(exported(tmp_path, text)).iter("DisplayUnit")
    assert dict(shown.items()) == {"name": "degC", "factor": "1.0", "offset": "-273.15"}


@pytest.mark.parametrize("version", VERSIONS)
def test_aliases_are_shown_in_units_of_their_own(tmp_path: Path, version: int) -> None:
    text = """model M
  output Real y = 2*a;
  Real a(unit="rad") = sin(time);
  Real b(unit="rad", displayUnit="deg") = a;
  Real c(unit="rad", displayUnit="mrad") = a;
end M;
"""
    root = described(exported(tmp_path, text, version))
    told = {e.get("name"): e.get("displayUnit") for v in root.iter("Float64") for e in (v, *v)}
    for v in root.iter("ScalarVariable"):
        told |= {v.get("name"): e.get("displayUnit") for e in v.iter("Real")}
    assert {name: told[name] for name in "abc"} == {"a": None, "b": "deg", "c": "mrad"}
    assert [u.get("name") for u in root.iter("DisplayUnit")] == ["deg", "mrad"]


@pytest.mark.parametrize("version", VERSIONS)
def test_values_of_other_units_are_no_aliases(tmp_path: Path, version: int) -> None:
    """The angle of the ground and the force on it are both zero."""
    path = tmp_path / "four_bar.fmu"
    model = planarc.load(EXAMPLES / "four_bar.pmo")
    model.export_fmu(path, fmi=version)
    assert validate_fmu(str(path)) == []
    units = {c.name: c.unit for c in model.program.columns}
    root = described(path)
    told = {
        a.get("name"): v.get("unit", "")
        for v in root.iter("Float64")
        for a in (v, *v.iter("Alias"))
    }
    for v in root.iter("ScalarVariable"):
        told |= {v.get("name"): e.get("unit", "") for e in v.iter("Real")}
    wrong = {n for n, unit in told.items() if n in units and units[n] not in ("1", unit)}
    assert not wrong and len(told) > 100


CONTROLLER = """model M
  input Real measured(start=0);
  output Real u(start=0, fixed=true);
  output Real y = 2*x;
  Real x(start=0, fixed=true);
equation
  der(x) = u - x;
  when sample(0, 0.1) then
    u = 3*(1 - measured);
  end when;
end M;
"""


@pytest.mark.parametrize("version", VERSIONS)
def test_what_outputs_follow_at_events_is_left_open(tmp_path: Path, version: int) -> None:
    """A controller's output follows its input at an event, where no slope tells it."""
    description = fmpy.read_model_description(exported(tmp_path, CONTROLLER, version))
    outputs = {o.variable.name: o for o in description.outputs}
    assert set(outputs) == {"u", "y"}
    assert all(o.dependencies is None for o in outputs.values())
    assert outputs["u"].variable.variability == "discrete"
    assert outputs["y"].variable.variability == "continuous"


def test_names_that_are_no_ascii_are_flat(tmp_path: Path) -> None:
    path = exported(
        tmp_path, "model M Real 'ü ñ'(start=1, fixed=true); equation der('ü ñ') = 1; end M;"
    )
    assert described(path).get("variableNamingConvention") == "flat"


@pytest.mark.parametrize(
    ("declared", "used", "kind"),
    [
        ("input Boolean on(start=true);", "if on then -x else 0", "Boolean and no Real"),
        ("input Integer n(start=1);", "-n*x", "Integer and no Real"),
        ("type E = enumeration(a, b); input E e;", "if e == E.a then -x else 0",
         "an enumeration and no Real"),
        ("discrete input Real d(start=1);", "-d*x", "discrete"),
    ],
)  # fmt: skip
def test_inputs_that_are_no_reals_are_refused(declared: str, used: str, kind: str) -> None:
    """They were left out, and the value at the start held for the whole run."""
    head = f"model M\n  {declared}\n  Real x(start=1, fixed=true);\n"
    text = f"{head}equation\n  der(x) = {used};\nend M;"
    with pytest.raises(PlanarcError, match=f"which is {kind}, cannot") as raised:
        planarc.load(text).export_fmu("unwritten.fmu")
    (found,) = raised.value.diagnostics
    assert found.code == "C300" and found.span is not None


@runs_here
def test_a_loop_that_cannot_be_closed_is_named(tmp_path: Path) -> None:
    path, told = tmp_path / "four_bar.fmu", list[str]()
    planarc.load(EXAMPLES / "four_bar.pmo").export_fmu(path)
    with pytest.raises(fmpy.fmi1.FMICallException):
        simulate(path, "CoSimulation", 1.0, start_values={"crank.r[1]": 30.0},
                 logger=lambda *given: told.append(given[-1].decode()))  # fmt: skip
    assert "the loop of `crank`, `coupler` and `rocker`" in told[0]


@runs_here
@pytest.mark.parametrize("interval", [1e-300, 1e-12])
def test_a_sampler_that_ticks_without_end_is_told(tmp_path: Path, interval: float) -> None:
    text = """model M
  parameter Real T=0.1;
  discrete output Real u(start=0, fixed=true);
equation
  when sample(0, T) then
    u = pre(u) + 1;
  end when;
end M;
"""
    path, told = exported(tmp_path, text), list[str]()
    with pytest.raises(fmpy.fmi1.FMICallException):
        simulate(path, "CoSimulation", 1.0, start_values={"T": interval},
                 logger=lambda *given: told.append(given[-1].decode()))  # fmt: skip
    assert told == ["a `sample` becomes true at more instants than a run can tell apart"]


@pytest.mark.parametrize("version", VERSIONS)
def test_what_is_protected_stays_inside(tmp_path: Path, version: int) -> None:
    """But for what a host is to see as an output."""
    text = """model M
  parameter Real a=2;
  Real x(start=1, fixed=true);
protected
  parameter Real b=3;
  Real rate = a*b*x;
  Real y(start=0, fixed=true);
equation
  der(x) = -rate;
  der(y) = x;
end M;
"""
    path = exported(tmp_path, text, version)
    names = {v.name for v in fmpy.read_model_description(path).modelVariables}
    assert {"a", "x", "y"} <= names and not {"b", "rate"} & names
    planarc.load(text).export_fmu(path, fmi=version, outputs="rate")
    assert "rate" in {v.name for v in fmpy.read_model_description(path).modelVariables}


SWING = """model Swing
  import PlanarMultiBody.{World, Joints, Parts};
  inner World world;
  Joints.Revolute hinge(phi(start=0.3, fixed=true), w(start=0, fixed=true));
  Parts.Body bob(m=1, I=0.01, r_CM={0, -1});
  output Real turned(unit="rad") = -hinge.phi;
  Real limited(unit="rad", min=-10, max=10) = hinge.phi;
  Real plain = hinge.phi;
  Real rate = der(plain);
equation
  connect(world.frame_b, hinge.frame_a);
  connect(hinge.frame_b, bob.frame_a);
end Swing;
"""
ANGLES = {"hinge.phi": 1, "bob.phi": 1, "bob.frame_a.phi": 1, "limited": 1, "plain": 1,
          "turned": -1}  # fmt: skip
SPEEDS = {"hinge.w": 1, "bob.w": 1, "rate": 1, "der(hinge.phi)": 1}


@runs_here
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("version", VERSIONS)
def test_a_start_is_set_by_any_name(tmp_path: Path, version: int, way: str) -> None:
    path = exported(tmp_path, SWING, version)
    unpacked, told = fmpy.extract(path), fmpy.read_model_description(path)

    def begin(**given: object) -> tuple[float, float]:
        """Angle and speed, where the host gives other starts."""
        found = fmpy.simulate_fmu(unpacked, model_description=told, fmi_type=way, stop_time=1e-3,
                                  output_interval=1e-3, output=["hinge.phi", "hinge.w"],
                                  **given)  # fmt: skip
        return float(found["hinge.phi"][0]), float(found["hinge.w"][0])

    for everything in (False, True):  # then all other names are set to what is described of them
        options = {"apply_default_start_values": everything}
        assert begin(**options) == (0.3, 0.0)
        for name, sign in ANGLES.items():
            assert begin(start_values={name: 0.5}, **options) == (0.5 * sign, 0.0)
        for name, sign in SPEEDS.items():
            assert begin(start_values={name: 0.5}, **options) == (0.3, 0.5 * sign)


@runs_here
def test_a_start_may_be_set_back_by_its_name(tmp_path: Path) -> None:
    path = exported(tmp_path, SWING)
    told = fmpy.read_model_description(path)
    of = {v.name: v.valueReference for v in told.modelVariables}
    fmu = fmpy.instantiate_fmu(fmpy.extract(path), told, "CoSimulation")
    for name, value in (("bob.phi", 0.5), ("plain", 0.3), ("plain", 0.7), ("turned", -0.3),
                        ("plain", 0.3)):  # fmt: skip
        fmu.setFloat64([of[name]], [value])
    fmu.enterInitializationMode()
    assert fmu.getFloat64([of["hinge.phi"]]) == [0.3]
    fmu.exitInitializationMode()
    fmu.freeInstance()


TURNING = """model M
  type Way = enumeration(left, right, 'straight on');
  parameter Way way=Way.right "Where it turns";
  parameter Real 'M.Way'=1;
  discrete output Way now(start=Way.'straight on', fixed=true);
  output Real x = if now == Way.left then -'M.Way' else 2*'M.Way';
equation
  when time > 0.5 then
    now = way;
  end when;
end M;
"""


@pytest.mark.parametrize("version", VERSIONS)
def test_enumerations_have_types(tmp_path: Path, version: int) -> None:
    known = fmpy.read_model_description(exported(tmp_path, TURNING, version)).modelVariables
    told = {v.name: v for v in known}
    way = told["way"]
    assert (way.type, way.start, way.description) == ("Enumeration", "2", "Where it turns")
    assert told["now"].type == "Enumeration" and told["now"].declaredType is way.declaredType
    assert way.declaredType.name not in told  # as the standard wants it
    items = [(item.name, item.value) for item in way.declaredType.items]
    assert items == [("left", "1"), ("right", "2"), ("'straight on'", "3")]


@runs_here
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("version", VERSIONS)
def test_enumerations_are_set_and_read(tmp_path: Path, version: int, way: str) -> None:
    path = exported(tmp_path, TURNING, version)
    for given, now, x in ((None, 2, 2.0), (1, 1, -1.0), ("3", 3, 2.0)):
        found = simulate(path, way, 1.0, start_values={} if given is None else {"way": given})
        assert (found["now"][0], found["x"][0]) == (3, 2.0)
        assert (found["now"][-1], found["x"][-1]) == (now, x)
        assert found["now"].dtype.kind == "i"


def test_enumerations_are_explained_to_people(tmp_path: Path) -> None:
    with ZipFile(exported(tmp_path, TURNING)) as archive:
        page = archive.read("documentation/index.html").decode()
    assert "Where it turns (1 left, 2 right, 3 &#x27;straight on&#x27;)" in page


LIMITED = """model M
  type Gap = Real(unit="m", min=0, nominal=1e-3);
  parameter Real L=2;
  final parameter Real K=3;
  constant Real C=4;
  parameter Real p(min=0, max=10)=3;
  parameter Real q(max=2)=2;
  input Real u(min=-1, max=1, start=0.5, nominal=0.1);
  output Real y = 2*known;
  Gap x(start=1, fixed=true);
  Real same(unit="m") = x;
  Real turned(unit="m") = -x;
  Real own(unit="m", min=-5, max=7) = x;
  Real own_turned(unit="m", max=3) = -x;
  Gap twice = 2*x;
  Real twice_too(unit="m") = twice;
  Real known(min=-K, max=2*C) = sin(time);
  Real open(min=-1, max=L, nominal=L) = cos(time);
  Real overstepped(min=3, max=9) = time;
  Real empty(min=3, max=2) = time + 2.5;
  Integer n(min=-2, max=7);
  discrete Real d(min=0, max=20, start=0, fixed=true);
equation
  der(x) = u*p*q;
  n = if time > 0.5 then 1 else 2;
  when sample(0, 0.1) then
    d = pre(d) + 1;
  end when;
end M;
"""


def limits_of(path: Path) -> dict[str, tuple[str | None, ...]]:
    """min, max and nominal of each name."""
    found = {}
    root = described(path)
    for v in [*root.iter("Float64"), *root.iter("Int32")]:
        for name in (v, *v.iter("Alias")):
            found[name.get("name", "")] = tuple(map(v.get, ("min", "max", "nominal")))
    for v in root.iter("ScalarVariable"):
        for told in (*v.iter("Real"), *v.iter("Integer")):
            found[v.get("name", "")] = tuple(map(told.get, ("min", "max", "nominal")))
    return found


@pytest.mark.parametrize("version", VERSIONS)
def test_variables_tell_their_limits(tmp_path: Path, version: int) -> None:
    wanted: dict[str, tuple[str | None, ...]] = {
        "x": ("0.0", None, "0.001"),
        "same": ("0.0", "7.0", "0.001"),  # those of all other names
        "twice": ("0.0", None, "0.001"),
        "twice_too": ("0.0", None, "0.001"),
        "turned": ("-7.0", "0.0", "0.001"),
        "own": ("-5.0", "7.0", "0.001"),
        "own_turned": (None, "3.0", "0.001"),
        "known": ("-3.0", "8.0", None),
        "open": ("-1.0", None, "2.0"),  # a host may set L
        "overstepped": (None, "9.0", None),
        "empty": (None, None, None),
        "u": ("-1.0", "1.0", "0.1"),
        "n": ("-2", "7", None),
        "d": ("0.0", "20.0", None),
        "p": ("0.0", "10.0", None),
        "der(x)": (None, None, None),
    }
    found = limits_of(exported(tmp_path, LIMITED, version))
    assert {name: found[name] for name in wanted} == wanted


@pytest.mark.parametrize("version", VERSIONS)
def test_a_start_lies_between_the_limits(tmp_path: Path, version: int) -> None:
    """What a model oversteps itself is no limit."""
    text = """model M
  parameter Real p(min=0)=-1;
  input Real u(max=1, start=2);
  Real x(min=1, max=3, start=0, fixed=true);
equation
  der(x) = u*p;
end M;
"""
    found = limits_of(exported(tmp_path, text, version))
    assert found["p"] == found["u"] == (None, None, None)
    assert found["x"] == (None, "3.0", None)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_limit_counts_where_its_parameters_cannot_be_set(tmp_path: Path, version: int) -> None:
    path = tmp_path / "a.fmu"
    planarc.load(LIMITED).export_fmu(path, fmi=version, parameters="p")
    assert limits_of(path)["open"] == ("-1.0", "2.0", "2.0")
