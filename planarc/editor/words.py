"""The words of the language that completion offers, by where they may stand."""

from __future__ import annotations

#: Words that begin a declaration, an equation, a section.
DECLARING = [
    "parameter",
    "constant",
    "discrete",
    "input",
    "output",
    "flow",
    "inner",
    "outer",
    "replaceable",
    "redeclare",
    "final",
    "protected",
    "public",
    "equation",
    "algorithm",
    "import",
    "extends",
    "model",
    "block",
    "connector",
    "record",
    "package",
    "function",
    "type",
    "partial",
    "encapsulated",
    "annotation",
    "end",
]
STATING = [
    "connect",
    "if",
    "for",
    "when",
    "while",
    "der",
    "assert",
    "equation",
    "algorithm",
    "annotation",
    "end",
    "initial",
]
STATING += ["protected", "public", "then", "elseif", "else", "elsewhen", "loop", "reinit"]
VALUING = [
    "true",
    "false",
    "if",
    "then",
    "else",
    "not",
    "and",
    "or",
    "time",
    "der",
    "pre",
    "initial",
    "terminal",
]

#: What annotations hold (chapter 18), and what planarc adds.
ANNOTATIONS: dict[str, tuple[str, ...]] = {
    "": (
        "Documentation", "Icon", "Diagram", "Placement", "Line", "experiment", "Dialog", "choices",
        "Evaluate", "HideResult", "uses", "version", "conversion", "Inline", "LateInline",
        "smoothOrder", "derivative", "inverse", "obsolete", "missingInnerMessage",
        "defaultComponentName", "defaultComponentPrefixes", "preferredView", "Include", "Library",
        "IncludeDirectory", "LibraryDirectory", "unassignedMessage", "absoluteValue", "__planarc",
    ),
    "experiment": ("StartTime", "StopTime", "Interval", "Tolerance"),
    "Documentation": ("info", "revisions", "figures"),
    "Dialog": (
        "tab", "group", "enable", "showStartAttribute", "colorSelector", "loadSelector",
        "saveSelector", "groupImage", "connectorSizing",
    ),
    "Placement": ("visible", "transformation", "iconTransformation", "iconVisible"),
    "transformation": ("origin", "extent", "rotation"),
    "choices": ("choice", "checkBox", "__planarc"),
    "figures": ("Figure",),
    "Figure": ("title", "identifier", "group", "preferred", "plots", "caption"),
    "Plot": ("title", "identifier", "curves", "x", "y"),
    "Curve": ("x", "y", "legend"),
    "__planarc": ("energy", "visual", "contact", "force", "event"),
}  # fmt: skip
