"""modelDescription.xml.

In:   Program, Interface, how the archive's library is called, its token
Out:  text

Units stand with their exponents of SI base units, where angles count as `rad`. What depends on
what is left out: then a host takes everything to depend on everything.

Reference: FMI 3.0.2, section 2.4.
"""

from __future__ import annotations

from xml.etree import ElementTree as Xml

from planarc.core.data import Data
from planarc.core.quantity import in_unit
from planarc.core.unit import factors, parse
from planarc.export.fmi.entries import INTEGER, NUMBER, TRUTH
from planarc.export.fmi.variables import Interface, Seen, shown_name
from planarc.ir.program import Program

_BASE = ("m", "kg", "s", "A", "K", "mol", "cd")
_NAMES_3 = {NUMBER: "Float64", INTEGER: "Int32", TRUTH: "Boolean"}


class Told(Data):
    """`identifier` names the library's file; `tolerance` is the one of co-simulation."""

    identifier: str
    token: str
    tool: str
    tolerance: float


def describe_three(program: Program, shown: Interface, told: Told) -> str:
    """The model description of FMI 3.0."""
    root = Xml.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=program.name,
        instantiationToken=told.token,
        description=program.description,
        generationTool=told.tool,
        variableNamingConvention="structured",
    )
    can = {"modelIdentifier": told.identifier, "canGetAndSetFMUState": "true",
           "canSerializeFMUState": "true"}  # fmt: skip
    Xml.SubElement(root, "ModelExchange", can, needsCompletedIntegratorStep="true")
    Xml.SubElement(root, "CoSimulation", can, canHandleVariableCommunicationStepSize="true",
                   hasEventMode="true")  # fmt: skip
    _units(root, shown)
    experiment = program.experiment
    Xml.SubElement(root, "DefaultExperiment", startTime=_number(experiment.start),
                   stopTime=_number(experiment.stop), tolerance=_number(experiment.tolerance),
                   stepSize=_number(_interval(program)))  # fmt: skip
    variables = Xml.SubElement(root, "ModelVariables")
    for v in shown.variables:
        _variable_three(variables, v)
    structure = Xml.SubElement(root, "ModelStructure")
    by_reference = {v.reference: v for v in shown.variables}
    states = [by_reference[r] for r in shown.states]
    rates = [by_reference[r] for r in shown.rates]
    for v in shown.variables:
        if v.causality == "output":
            Xml.SubElement(structure, "Output", valueReference=str(v.reference))
    for v in rates:
        Xml.SubElement(structure, "ContinuousStateDerivative", valueReference=str(v.reference))
    unknown = [v for v in (*states, *rates) if v.initial == "calculated"]
    unknown += [v for v in shown.variables if v.is_unknown and v not in unknown]
    listed = [("InitialUnknown", r) for r in dict.fromkeys(x.reference for x in unknown)]
    for kind, reference in (*listed, *(("EventIndicator", r) for r in shown.indicators)):
        Xml.SubElement(structure, kind, valueReference=str(reference))
    return _text(root)


def _variable_three(parent: Xml.Element, v: Seen) -> None:
    given = {"name": v.name, "valueReference": str(v.reference), "causality": v.causality,
             "variability": v.variability}  # fmt: skip
    if v.description:
        given["description"] = v.description
    if v.initial is not None:
        given["initial"] = v.initial
    given |= _typed(v)
    if v.derivative is not None:
        given["derivative"] = str(v.derivative)
    element = Xml.SubElement(parent, _NAMES_3[v.kind], given)
    for column in v.aliases:
        alias = Xml.SubElement(element, "Alias", name=shown_name(column))
        if column.description:
            alias.set("description", column.description)


def _typed(v: Seen) -> dict[str, str]:
    """Unit, limits and start value."""
    given: dict[str, str] = {}
    if v.unit and factors(v.unit) is not None:
        given["unit"] = v.unit
        if _display(v.unit, v.display_unit) is not None:
            given["displayUnit"] = v.display_unit
    for name, value in (("min", v.minimum), ("max", v.maximum), ("start", v.start)):
        if value is not None:
            given[name] = _value(value, v.kind)
    return given


def _units(root: Xml.Element, shown: Interface) -> None:
    pairs: dict[str, dict[str, None]] = {}
    for v in shown.variables:
        if v.unit and factors(v.unit) is not None:
            pairs.setdefault(v.unit, {})[v.display_unit] = None
    if not pairs:
        return
    units = Xml.SubElement(root, "UnitDefinitions")
    for name, displays in pairs.items():
        unit = Xml.SubElement(units, "Unit", name=name)
        base = dict(zip(_BASE, map(int, parse(name) or ()), strict=False))
        base["rad"] = sum(e for _, s, e in factors(name) or () if s in ("rad", "deg", "rev"))
        given = {k: str(e) for k, e in base.items() if e}
        Xml.SubElement(unit, "BaseUnit", given)
        for display in displays:
            factor = _display(name, display)
            if factor is not None:
                Xml.SubElement(unit, "DisplayUnit", name=display, factor=_number(factor))


def _display(unit: str, display: str) -> float | None:
    """What a number in the unit is multiplied by to be shown; None where nothing is."""
    if not display or display == unit or factors(display) is None or "degC" in (unit, display):
        return None
    return in_unit("", f"1 {unit}", display)


def _interval(program: Program) -> float:
    experiment = program.experiment
    return experiment.interval or (experiment.stop - experiment.start) / 500


def _value(value: float, kind: int) -> str:
    if kind == TRUTH:
        return "true" if value else "false"
    return str(int(value)) if kind == INTEGER else _number(value)


def _number(value: float) -> str:
    return repr(float(value))


def _text(root: Xml.Element) -> str:
    Xml.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + Xml.tostring(root, "unicode") + "\n"
