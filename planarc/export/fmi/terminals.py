"""terminalsAndIcons.xml: flanges and frames whose variables a host connects.

In:   Program, Interface
Out:  text, or "" where no input or output belongs to one

Flow variables are positive into the component, and so `inflow`.

Reference: FMI 3.0.2, section 2.4.11 (terminals).
"""

from __future__ import annotations

import re
from xml.etree import ElementTree as Xml

from planarc.export.fmi.variables import Interface
from planarc.ir.program import Program

_CONNECTOR = re.compile(r"\.Interfaces\.(Frame|Flange)(_\w+)?$")
#: Members that flow: of frames `f[1]`, `f[2]`, `t`; of flanges `tau`, `f`.
_FLOW = re.compile(r"f(\[\d\])?|t|tau")


def describe_terminals(program: Program, shown: Interface) -> str:
    """Terminals by the names of their components."""
    connectors = {p.name: p.class_name for p in program.parts if _CONNECTOR.search(p.class_name)}
    root = Xml.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    terminals = Xml.SubElement(root, "Terminals")
    found: dict[str, Xml.Element] = {}
    for v in shown.variables:
        owner, _, member = v.name.rpartition(".")
        if v.causality not in ("input", "output") or owner not in connectors:
            continue
        if owner not in found:
            given = {"name": owner, "matchingRule": "plug", "terminalKind": connectors[owner]}
            found[owner] = Xml.SubElement(terminals, "Terminal", given)
        kind = "inflow" if _FLOW.fullmatch(member) else "signal"
        Xml.SubElement(found[owner], "TerminalMemberVariable", variableName=v.name,
                       memberName=member, variableKind=kind)  # fmt: skip
    if not found:
        return ""
    Xml.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + Xml.tostring(root, "unicode") + "\n"
