"""modelDescription.xml.

In:   Program, Interface, how the archive's library is called, its token
Out:  text

Units stand with their exponents of SI base units, where angles count as `rad`. Where it is left
out what a value depends on, as where states are exchanged, a host takes it to depend on all.

Reference: FMI 3.0.2, section 2.4; FMI 2.0.4, section 2.2.
"""

from __future__ import annotations

from collections.abc import Callable
from xml.etree import ElementTree as Xml

from msgspec.structs import replace

from planarc.core.data import Data
from planarc.core.quantity import scale
from planarc.core.unit import factors, parse
from planarc.export.fmi.entries import CATEGORIES, INTEGER, NUMBER, TRUTH
from planarc.export.fmi.variables import Interface, Seen, shown_name
from planarc.instance.plan import is_eventful
from planarc.ir.program import Program

_BASE = ("m", "kg", "s", "A", "K", "mol", "cd")
#: What aliases of FMI 2.0, which are variables, say as the variable does.
_OF_ALIASES = ("unit", "declaredType", "min", "max", "nominal")
_ENUMERATION = "Enumeration"
_NAMES_3 = {NUMBER: "Float64", INTEGER: "Int32", TRUTH: "Boolean"}
_NAMES_2 = {NUMBER: "Real", INTEGER: "Integer", TRUTH: "Boolean"}


class Told(Data):
    """`identifier` names the library's file, `version` is 2 or 3; with `slopes` there are
    derivatives; `sources` are files that a compiler is given. For `exchange` of the model: without,
    it is for co-simulation alone."""

    version: int
    identifier: str
    token: str
    tool: str
    slopes: bool = False
    sources: tuple[str, ...] = ()
    exchange: bool = True


def describe(program: Program, shown: Interface, told: Told) -> str:
    """The model description for a version of the standard."""
    three = told.version == 3
    root = Xml.Element(
        "fmiModelDescription",
        {
            "fmiVersion": "3.0" if three else "2.0",
            "modelName": program.name,
            "instantiationToken" if three else "guid": told.token,
            "description": program.description,
            "generationTool": told.tool,
            "variableNamingConvention": _convention(shown),
        },
    )
    state = "FMUState" if three else "FMUstate"
    can = {
        "modelIdentifier": told.identifier,
        f"canGetAndSet{state}": "true",
        f"canSerialize{state}": "true",
    }
    if told.slopes:
        given = "DirectionalDerivatives", "AdjointDerivatives"
        can |= {f"provides{name}": "true" for name in (given if three else (given[0][:-1],))}
    kinds = [Xml.SubElement(root, "ModelExchange", can)] if told.exchange else []
    steps = Xml.SubElement(root, "CoSimulation", can, canHandleVariableCommunicationStepSize="true")
    if three:
        for exchange in kinds:
            exchange.set("needsCompletedIntegratorStep", "true")
        offers = ("hasEventMode", "providesIntermediateUpdate",
                  "canReturnEarlyAfterIntermediateUpdate")  # fmt: skip
        for name in (*offers, *("mightReturnEarlyFromDoStep",) * is_eventful(program)):
            steps.set(name, "true")
    else:
        if told.exchange:
            root.set("numberOfEventIndicators", str(len(shown.indicators)))
        for kind in (*kinds, steps) if told.sources else ():
            files = Xml.SubElement(kind, "SourceFiles")
            for name in told.sources:
                Xml.SubElement(files, "File", name=name)
    _units(root, shown)
    _types(root, shown, three)
    categories = Xml.SubElement(root, "LogCategories")
    for name in CATEGORIES:
        Xml.SubElement(categories, "Category", name=name)
    experiment = program.experiment
    Xml.SubElement(
        root,
        "DefaultExperiment",
        startTime=_number(experiment.start),
        stopTime=_number(experiment.stop),
        tolerance=_number(experiment.tolerance),
        stepSize=_number(_interval(program)),
    )
    (_three if three else _two)(root, shown)
    return write_xml(root)


def _convention(shown: Interface) -> str:
    """Names in quotes that are no ASCII are none of the structured ones."""
    names = [n for v in shown.variables for n in (v.name, *map(shown_name, v.aliases))]
    return "structured" if all(map(str.isascii, names)) else "flat"


def _unknowns(shown: Interface) -> tuple[list[Seen], list[Seen], list[Seen]]:
    """Outputs, derivatives of the states, and what is computed at the start."""
    by_reference = {v.reference: v for v in shown.variables}
    rates = [by_reference[r] for r in shown.rates]
    own = {*shown.states, *shown.rates}
    outputs = [v for v in shown.variables if v.causality == "output"]
    first = [
        v
        for v in shown.variables
        if v.initial == "calculated" and (v.reference in own or v.causality == "output")
    ]
    return outputs, rates, first


def _three(root: Xml.Element, shown: Interface) -> None:
    variables = Xml.SubElement(root, "ModelVariables")
    for v in shown.variables:
        _variable_three(variables, v)
    structure = Xml.SubElement(root, "ModelStructure")
    kinds = ("Output", "ContinuousStateDerivative", "InitialUnknown")
    for kind, found in zip(kinds, _unknowns(shown), strict=True):
        for v in found:
            depends = {} if kind == "InitialUnknown" else _depends(shown, v, int)
            Xml.SubElement(structure, kind, {"valueReference": str(v.reference), **depends})
    for reference in shown.indicators:
        Xml.SubElement(structure, "EventIndicator", valueReference=str(reference))


def _depends(shown: Interface, v: Seen, number: Callable[[int], int]) -> dict[str, str]:
    """What an unknown depends on, by the numbers that a version has for variables."""
    known = shown.dependencies.get(v.reference)
    if known is None:
        return {}
    pairs = sorted((number(r), kind) for r, kind in known.items())
    kinds = {"dependenciesKind": " ".join(kind for _, kind in pairs)} if pairs else {}
    return {"dependencies": " ".join(str(n) for n, _ in pairs)} | kinds


def _two(root: Xml.Element, shown: Interface) -> None:
    """Aliases are variables with the reference of another one; unknowns are told by numbers."""
    variables = Xml.SubElement(root, "ModelVariables")
    numbers: dict[int, int] = {}
    count = 0
    for v in shown.variables:
        count += 1
        numbers[v.reference] = count
        count += len(v.aliases)
    for v in shown.variables:
        _variable_two(variables, v, numbers)
    structure = Xml.SubElement(root, "ModelStructure")
    kinds = ("Outputs", "Derivatives", "InitialUnknowns")
    for kind, found in zip(kinds, _unknowns(shown), strict=True):
        if found:
            parent = Xml.SubElement(structure, kind)
            for v in found:
                depends = {}
                if kind != "InitialUnknowns":
                    depends = _depends(shown, v, numbers.__getitem__)
                Xml.SubElement(parent, "Unknown", {"index": str(numbers[v.reference]), **depends})


def _variable_two(parent: Xml.Element, v: Seen, numbers: dict[int, int]) -> None:
    typed = _typed(v)
    if v.derivative is not None:
        typed["derivative"] = str(numbers[v.derivative])
    kind = _ENUMERATION if v.type else _NAMES_2[v.kind]
    Xml.SubElement(Xml.SubElement(parent, "ScalarVariable", _head(v)), kind, typed)
    shared = {name: told for name, told in typed.items() if name in _OF_ALIASES}
    for column in v.aliases:
        own = shared | _displayed(v.unit, column.display_unit)
        other = replace(
            v,
            name=shown_name(column),
            description=column.description,
            causality="local",
            initial="calculated",
        )
        element = Xml.SubElement(parent, "ScalarVariable", _head(other))
        Xml.SubElement(element, kind, own)


def _head(v: Seen) -> dict[str, str]:
    """What all kinds of variables say of themselves, but for what the standard takes for granted.
    References stand before names: what differs stands together, and packs better."""
    given = {"valueReference": str(v.reference), "name": v.name}
    if v.causality != "local":
        given["causality"] = v.causality
    if v.variability != ("continuous" if v.kind == NUMBER else ""):
        given["variability"] = v.variability
    if v.description:
        given["description"] = v.description
    if v.initial not in (None, "exact" if v.causality == "parameter" else "calculated"):
        given["initial"] = v.initial
    return given


def _variable_three(parent: Xml.Element, v: Seen) -> None:
    given = _head(v) | _typed(v)
    if v.causality == "output" and v.variability == "continuous":
        given["intermediateUpdate"] = "true"
    if v.derivative is not None:
        given["derivative"] = str(v.derivative)
    element = Xml.SubElement(parent, _ENUMERATION if v.type else _NAMES_3[v.kind], given)
    for column in v.aliases:
        alias = Xml.SubElement(element, "Alias", name=shown_name(column))
        if column.description:
            alias.set("description", column.description)
        alias.attrib |= _displayed(v.unit, column.display_unit)


def _typed(v: Seen) -> dict[str, str]:
    """Unit, type, limits and start value."""
    given: dict[str, str] = {"declaredType": v.type.name} if v.type else {}
    if v.unit and factors(v.unit) is not None:
        given["unit"] = v.unit
        given |= _displayed(v.unit, v.display_unit)
    limits = (("min", v.minimum), ("max", v.maximum), ("nominal", v.nominal), ("start", v.start))
    for name, value in limits:
        if value is not None:
            given[name] = _value(value, v.kind)
    return given


def _units(root: Xml.Element, shown: Interface) -> None:
    pairs: dict[str, dict[str, None]] = {}
    for v in shown.variables:
        if v.unit and factors(v.unit) is not None:
            told = (v.display_unit, *(column.display_unit for column in v.aliases))
            pairs.setdefault(v.unit, {}).update(dict.fromkeys(told))
    if not pairs:
        return
    units = Xml.SubElement(root, "UnitDefinitions")
    for name, displays in pairs.items():
        unit = Xml.SubElement(units, "Unit", name=name)
        base = dict(zip(_BASE, map(int, parse(name) or ()), strict=False))
        base["rad"] = sum(e for _, s, e in factors(name) or () if s in ("rad", "deg", "rev"))
        given = {k: str(e) for k, e in base.items() if e} | _scaled(*scale(name))
        Xml.SubElement(unit, "BaseUnit", given)
        for display in displays:
            scaled = _display(name, display)
            if scaled is not None:
                given = {"name": display, "factor": _number(scaled[0])} | _scaled(1.0, scaled[1])
                Xml.SubElement(unit, "DisplayUnit", given)


def _types(root: Xml.Element, shown: Interface, three: bool) -> None:
    """The enumerations."""
    types = {v.type.name: v.type for v in shown.variables if v.type}
    if not types:
        return
    definitions = Xml.SubElement(root, "TypeDefinitions")
    for type in types.values():
        tag = "EnumerationType" if three else "SimpleType"
        parent = Xml.SubElement(definitions, tag, name=type.name)
        if not three:
            parent = Xml.SubElement(parent, _ENUMERATION)
        for k, name in enumerate(type.literals, 1):
            Xml.SubElement(parent, "Item", name=name, value=str(k))


def _scaled(factor: float, offset: float) -> dict[str, str]:
    """As attributes, but for those that change nothing."""
    told = (("factor", factor, 1.0), ("offset", offset, 0.0))
    return {name: _number(value) for name, value, nothing in told if value != nothing}


def _display(unit: str, display: str) -> tuple[float, float] | None:
    """What a number in the unit is multiplied by to be shown, and what is then added; None where
    nothing is."""
    if not display or display == unit or parse(display) != parse(unit):
        return None
    (factor, offset), (shown, zero) = scale(unit), scale(display)
    return factor / shown, (offset - zero) / shown


def _displayed(unit: str, display: str) -> dict[str, str]:
    """The unit in which a number is shown, as an attribute."""
    known = factors(unit) is not None and _display(unit, display) is not None
    return {"displayUnit": display} if known else {}


def _interval(program: Program) -> float:
    experiment = program.experiment
    return experiment.interval or (experiment.stop - experiment.start) / 500


def _value(value: float, kind: int) -> str:
    if kind == TRUTH:
        return "true" if value else "false"
    return str(int(value)) if kind == INTEGER else _number(value)


def _number(value: float) -> str:
    return repr(float(value))


def write_xml(root: Xml.Element) -> str:
    """The text of a file."""
    Xml.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + Xml.tostring(root, "unicode") + "\n"
