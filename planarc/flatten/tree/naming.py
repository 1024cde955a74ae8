"""Messages about names: what is not there, and what the user may have meant."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

from planarc.core.diagnostic import Once, PlanarcError, error, said
from planarc.core.mend import Meant
from planarc.core.nearest import did_you_mean, in_other_words, synonyms
from planarc.core.prose import either, shortened, ticked
from planarc.core.resources import stdlib
from planarc.core.source import Span
from planarc.flatten.library.beside import package_beside
from planarc.flatten.library.library import Library
from planarc.flatten.tree import predefined
from planarc.flatten.tree.annotation import arguments_of, binding_of, find_argument
from planarc.flatten.tree.demand import static_instance
from planarc.flatten.tree.nodes import Class, Instance, Scope
from planarc.ir import syntax


def name_span(element: syntax.Declaration) -> Span:
    """The place of a declared name."""
    return element.name_span if isinstance(element, syntax.ClassDef) else element.span


def unknown(
    scope: Scope, name: str, span: Span, counters: Collection[str] = (), value: bool = False
) -> PlanarcError:
    """The error of a name that nothing in sight has. `counters` are those of the loops around.
    `value`: the name alone stands for a value, which no class has."""
    where = scope.instance.cls.name
    message = f"unknown name `{name}`" + (f" in `{where}`" if where else "")
    known = names_in_sight(scope)
    moving = _differentiated(name, known)
    if moving is None and name == "dt" and (over := _over(span)):
        moving = _differentiated(over, known)
    if moving is not None:
        told = f"write `der({moving})` for the derivative of `{moving}`"
        return PlanarcError(Once("F210", message, span, hint=told, kind="derivative"))
    elsewhere = f"write {_WHOLE[name]}" if name in _WHOLE else None
    if elsewhere and scope.instance.parent is not None:  # a part has what the model around it has
        elsewhere = elsewhere.replace("`inner ", "`outer ")
    if elsewhere is None and not value and (place := _elsewhere(scope.session.library, name)):
        elsewhere = f"import it, or {place}"
    near = did_you_mean(name, [*counters, *known]) or did_you_mean(name, ["time"])
    small = name.lower()
    if elsewhere and small in scope.part.visible and re.match(rf"{name}\.[a-z]", span.text):
        elsewhere, near = None, Meant(name, (small,))  # `World.frame_b` of the part `world`
    library = scope.session.library
    if elsewhere is None and _begins_path(name, span) and (at := package_beside(span, name)):
        elsewhere = f"the package `{name}` stands beside this file: give `--library {at}`"
    if elsewhere is None and near is None and _begins_path(name, span):
        known_ones = ticked(n for n in sorted(library.top_names()) if library.added(n) is None)
        elsewhere = f"give the folder of that library with `--library`; found are {known_ones}"
    if near is None and counters:
        near = Meant(name, tuple(sorted(counters)))
    if near is None and name.startswith("'"):
        elsewhere = "a text stands in double quotes; single ones make a name"
    # A name that is used is used again: once for a class.
    mend, kind = None if elsewhere else near, f"{where} {name}"
    if any(_type_of(d) == "extend" for _, d in scope.instance.layout.members.values()):
        kind = f"{where} extends"  # what that class would have brought is not known, either
    return PlanarcError(
        Once("F210", message, span, hint=elsewhere or said(near), mend=mend, kind=kind)
    )


def _type_of(declaration: syntax.Declaration) -> str:
    return str(declaration.type) if isinstance(declaration, syntax.Component) else ""


def _begins_path(name: str, span: Span) -> bool:
    """Whether a name is written as that of a library: `Name.Class`."""
    return name[:1].isupper() and re.match(rf"{re.escape(name)}\.\w", span.text) is not None


def _over(span: Span) -> str:
    """The name that a name divides: `dx` of the `dt` in `dx/dt`."""
    before = re.search(r"(\w+)\s*/\s*$", span.source.text[: span.start])
    return before[1] if before else ""


def _differentiated(name: str, known: Collection[str]) -> str | None:
    """The variable whose derivative other languages call `xdot`, `dx` or `xp`."""
    found = (m for form in _DERIVATIVES if (m := re.fullmatch(form, name)) and m[1] in known)
    return next((m[1] for m in found), None)


_DERIVATIVES = ("(.+?)_?dot", "d(.+?)(?:_?dt)?", "D(.+)", "(.+)p", "der_?(.+)", "(.+)_der")


#: Names that need their package before them, or a declaration that all parts see.
_WHOLE = {
    "pi": "`Modelica.Constants.pi`",
    "PI": "`Modelica.Constants.pi`",
    "rpm": "`Modelica.Units.Conversions.from_rpm(...)`: speeds are in rad/s",
    "deg": "`Modelica.Units.Conversions.from_deg(...)`: angles are in rad",
    **dict.fromkeys(("float", "double", "var", "real"), "`Real`"),
    **dict.fromkeys(("int", "integer"), "`Integer`"),
    **dict.fromkeys(("bool", "boolean"), "`Boolean`"),
    **dict.fromkeys(("str", "string"), "`String`"),
    **dict.fromkeys(("yes", "on", "True", "TRUE"), "`true`"),
    **dict.fromkeys(("no", "off", "False", "FALSE"), "`false`"),
    "extend": "`extends` to take over all that a class has",
    "world": "`inner PlanarMultiBody.World world;` among the declarations",
}


def _elsewhere(library: Library, name: str) -> str | None:
    """The places of classes of this name in the libraries, if not too deep."""
    packages, found = ["PlanarMultiBody", "Modelica"], []
    for _ in range(_DEEPEST):
        inside = [f"{p}.{c}" for p in packages for c in library.class_names(p)]
        found += [full for full in inside if full.rpartition(".")[2] == name]
        packages = [f for f in inside if ".Examples" not in f and library.may_hold(f, name)]
    return f"write {either(found[:3])}" if found else None


_DEEPEST = 4  # packages inside of a library in which a name is looked for


def spatial(message: str, span: Span) -> PlanarcError:
    """The library of mechanisms in space, which is not here."""
    hint = "mechanisms are planar here: write `PlanarMultiBody` for `Modelica.Mechanics.MultiBody`"
    return PlanarcError(Once("F213", message, span, hint=hint, kind="MultiBody"))


def left_out(cls: Class) -> str | None:
    """What to do about a class of another library of which planarc brings a part along."""
    path = cls.definition.span.source.path
    if cls.name.partition(".")[0] != _PARTLY or path is None or not path.is_relative_to(stdlib()):
        return None
    return (
        f"planarc brings the part of `{_PARTLY}` along that mechanics in the plane needs: give the "
        "folder of the whole library with `--library`, or in MODELICAPATH"
    )


_PARTLY = "Modelica"


#: The components of an instance that have an element of one of some names, and which one.
Holders = Callable[[Sequence[str]], Iterable[tuple[str, str]]]


def missing_member(cls: Class, name: str, span: Span, holders: Holders) -> PlanarcError:
    message = f"`{cls.name}` has no element `{name}`"
    if (cls.name, name) == ("Modelica.Mechanics", "MultiBody"):
        return spatial(message, span)
    instance = static_instance(cls)
    if reason := _unconnectable(instance):
        return PlanarcError(Once("F213", message, span, hint=reason, kind=reason))
    names = member_names(instance)
    kind = f"{cls.name}.{name}"
    if not synonyms(name, names) and (told := _rate_or_inside(name, names, span, holders)):
        return PlanarcError(Once("F213", message, span, hint=told, kind=kind))
    near = did_you_mean(name, names)
    hint = said(near or _offered(instance.layout.members, False))
    hint = hint or _elsewhere(instance.session.library, name) or left_out(cls)
    if hint is None and 0 < len(names) <= _MOST_OFFERED:
        hint = f"it holds {either(names)}"
    if near is not None and (switch := _switch(instance.layout.members.get(near.names[0]))):
        hint = f"{hint} It is there with `{switch}=true`"
    return PlanarcError(Once("F213", message, span, hint=hint, mend=near, kind=kind))


def _rate_or_inside(name: str, names: Collection[str], span: Span, holders: Holders) -> str | None:
    """What to write for an acceleration that is no variable, and for what a part inside has."""
    found = re.match(rf"(.*)\.{re.escape(name)}\b", span.text)
    path = found[1] if found else None
    if path is None:
        return None
    speed = next((s for s in _SPEEDS if s in names), None)
    if speed is not None and name in _ACCELERATIONS:
        return f"write `der({path}.{speed})`"
    inside = list(holders((name,))) or list(holders(in_other_words(name)))
    if not inside or (len(name) > 1 and did_you_mean(name, names)):
        return None
    written = [f"{path}.{part}.{own}" for part, own in inside[:_MOST_HOLDERS]]
    return f"its part{'s have' if len(written) > 1 else ' has'} that: write {either(written)}"


_SPEEDS = ("w", "v")
_ACCELERATIONS = ("a", "z", "alpha", "acc", "acceleration")


def _unconnectable(instance: Instance) -> str | None:
    """What a class, or a base of it, says of how it is used in the place of being connected."""
    for part in instance.layout.parts:
        found = arguments_of(part.definition.annotation, _NO_FRAME, instance.session)
        value = binding_of(find_argument(found, _NO_FRAME))
        if isinstance(value, syntax.String):
            return " ".join(value.value.split())
    return None


_NO_FRAME = "hasNoFrame"


def _switch(slot: tuple[int, syntax.Declaration] | None) -> str | None:
    """The parameter that must be true for a component to be there."""
    condition = slot[1].condition if slot and isinstance(slot[1], syntax.Component) else None
    return str(condition) if isinstance(condition, syntax.Ref) else None


def not_modifiable(
    owner: str, name: str, span: Span | None, members: Members, holders: Sequence[str] = ()
) -> PlanarcError:
    """The error of a modifier of what a class does not have; `holders` are components that do."""
    message = f"`{owner}` has no element `{name}` to modify"
    beside = span and re.search(r"(\w+)\s*\([^()]*\)\s*,\s*$", span.source.text[: span.start])
    if name in _OF_VARIABLES and beside and beside[1] in members:
        told = f"it belongs to a variable: write it inside of `{beside[1]}(...)`"
        return error("F222", message, span, hint=told)
    number = span and re.search(r"=\s*([-+.\d{][^=]*)$", span.text)
    near = did_you_mean(name, members)
    meant = _started(name, members)
    if number and meant and (near is None or near.names[0] == meant):
        value = number[1].strip()
        told = f"write `{meant}(start={value}, fixed=true)` for a value at the start"
        return error("F222", message, span, hint=told)
    if holders and not near:
        rest = span.text[len(name) :] if span and span.text.startswith(name) else "(...)"
        written = " or ".join(f"`{h}({name}{rest})`" for h in holders[:_MOST_HOLDERS])
        return error("F222", message, span, hint=f"its parts have that: write {written}")
    values = span is None or re.search(r"\b(start|fixed)\s*=", span.text) is None
    hint = near or _offered(members, values)
    return error("F222", message, span, hint=hint)


_MOST_HOLDERS = 2


def _started(name: str, members: Members) -> str | None:
    """The variable whose start others set by a parameter such as `phi_start` or `w0`."""
    for form in _STARTS:
        found = re.fullmatch(form, name)
        declared = members.get(found[1], (0, None))[1] if found else None
        if found and isinstance(declared, syntax.Component):
            moves = declared.variability is syntax.Variability.CONTINUOUS
            return found[1] if moves else None
    return None


_STARTS = (r"(\w+?)_?(?:start|init|initial|0)", r"(?:start|init|initial)_(\w+)")

_OF_VARIABLES = frozenset(("fixed", "start", "min", "max", "nominal", "stateSelect", "unit"))

#: Names of a class, each with its part and declaration.
Members = Mapping[str, tuple[int, syntax.Declaration]]


def _offered(members: Members, parameters: bool) -> str | None:
    """The hint that names what there is, where nothing is near to a name."""
    names = [
        name
        for name, (_, d) in members.items()
        if isinstance(d, syntax.Component)
        and not (d.prefixes.protected or d.prefixes.final or d.prefixes.outer)
        and (d.variability is syntax.Variability.PARAMETER) is parameters
    ]
    # Those that need a value are what a part is about; then those of the class before its bases'.
    names.sort(key=lambda n: (_has_value(members[n][1]), members[n][0]))
    kind = "parameters are" if parameters else "elements are"
    return f"its {kind} {shortened([f'`{n}`' for n in names], _MOST_OFFERED)}" if names else None


def _has_value(declaration: syntax.Declaration) -> bool:
    modification = isinstance(declaration, syntax.Component) and declaration.modification
    return bool(modification and modification.binding)


_MOST_OFFERED = 8


def names_in_sight(scope: Scope) -> list[str]:
    names: list[str] = []
    current: Scope | None = scope
    while current is not None:
        names += sorted(current.part.visible)
        for clause in current.part.imports:
            if clause.wildcard:
                names += scope.session.library.class_names(".".join(clause.path))
            else:
                names += clause.names or [clause.alias or clause.path[-1]]
        for entry in current.part.entries:
            names += entry.child_names()
        current = None if current.part.definition.encapsulated else current.parent
    return [*names, *predefined.NAMES]


def member_names(instance: Instance) -> list[str]:
    names = list(instance.layout.members)
    if instance.layout.builtin is not None:
        names += instance.layout.builtin.literals
    for part in instance.layout.parts:
        if part.cls.entry is not None and part.cls.entry.open:
            names += part.cls.entry.child_names()
    return names
