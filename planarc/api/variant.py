"""Requests for a model that differs from another one: other structural parameters, more
declarations. The variant is a model that extends the one asked for:

    model FourBarVariant
      extends FourBar(revA(drivenFlange = true));
    end FourBarVariant;
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TypeAlias

from msgspec.structs import replace

from planarc.api.values import elements_of
from planarc.compiled import Compiled
from planarc.compiler import compile_model
from planarc.core.diagnostic import usage_error
from planarc.core.options import Backend
from planarc.core.prose import be, both
from planarc.core.source import decode
from planarc.flatten.tree.predefined import NAMES as PREDEFINED
from planarc.ir.program import ParameterSlot, Program, whole_name
from planarc.request.reader import content_of
from planarc.request.request import Request, open_target
from planarc.stages import flatten

#: The name of the variant, which no user's class has.
NAME = "'a variant'"


_Tree: TypeAlias = "dict[str, _Tree | str]"


class Recompiled(UserWarning):
    """A structural parameter was changed, or one that is computed from others was given a value of
    its own, so the model was compiled again."""


def why_again(program: Program, names: Collection[str]) -> str:
    """Why other values of some parameters make another model."""
    structural = {p.name for p in program.parameter_slots if p.structural}
    shaping = [n for n in names if n in structural]
    computed = [n for n in names if n not in structural]
    told = [f"{both(shaping)} {be(len(shaping))} structural"] if shaping else []
    if computed:
        told.append(f"{both(computed)} {be(len(computed))} computed from others")
    return " and ".join(told)


def variant_of(
    request: Request,
    values: Mapping[str, str] | None = None,
    declarations: str = "",
    classes: Mapping[str, str] | None = None,
) -> Request:
    """A request for the same class with some values as Modelica text, and more declarations.

    `classes` puts classes, by their full names, in the place of replaceable components.
    """
    target = open_target(request)
    name = target.class_name
    if request.text is not None:
        text = request.text
    elif request.file is not None:
        text = decode(content_of(request.file))
    else:
        text = ""
    tree = _redeclared(_tree(values or {}), classes or {})
    extends = f"extends {name}{_modifier(tree)};"
    full = f"{text}\nmodel {NAME}\n  {extends}\n{declarations}\nend {NAME};\n"
    within = name.rpartition(".")[0] if _begins_within(text) else ""
    wanted = f"{within}.{NAME}" if within else NAME
    return replace(request, class_name=wanted, text=full)


def texts_of(
    request: Request, program: Program, changed: Mapping[str, float], backend: Backend
) -> dict[str, str]:
    """Values of structural parameters as Modelica text, by names without subscripts.

    A modifier gives an array whole: `a[2].n` becomes `a.n`, with the other elements as
    they are after what else is changed. Raises UsageError (C204, C205).
    """
    slots = {p.name: p for p in program.parameter_slots}
    types = _types(request) if any(slots[n].literals for n in changed) else {}

    def literal(name: str, value: float) -> str:
        return _literal(slots[name], value, types.get(name, types.get(whole_name(name), "")))

    texts = {n: literal(n, v) for n, v in changed.items() if "[" not in n}
    for array in dict.fromkeys(whole_name(n) for n in changed if "[" in n):
        elements = elements_of(array, slots)
        values = _present(variant_of(request, texts) if texts else request, backend)
        values |= changed
        _refuse_computed([slots[n] for n in elements.values()], changed)
        texts[array] = _braces({at: literal(n, values[n]) for at, n in elements.items()})
    return texts


def _types(request: Request) -> dict[str, str]:
    """The names of the types of all variables."""
    return {v.name: v.type.name for v in flatten(open_target(request)).variables}


def _present(request: Request, backend: Backend) -> dict[str, float]:
    """The values of all parameters of a model."""
    compiled = compile_model(request, backend)
    kernel = compiled.load()
    kernel.parameters()
    return {p.name: float(kernel.w[p.slot]) for p in compiled.program.parameter_slots}


def _refuse_computed(elements: Sequence[ParameterSlot], changed: Mapping[str, float]) -> None:
    """An element that follows other parameters would follow them no longer."""
    for element in elements:
        if not (element.name in changed or element.settable or element.structural):
            one = next(n for n in changed if "[" in n and whole_name(n) == whole_name(element.name))
            raise usage_error(
                "C205",
                f"`{one}` is one of an array, of which `{element.name}` is computed from other "
                "parameters: it cannot be changed alone",
                hint="change it in the model, or give all elements",
            )


def _braces(elements: Mapping[tuple[int, ...], str]) -> str:
    """`{{a, b}, {c, d}}`, of elements in the order of their subscripts."""
    if () in elements:
        return elements[()]
    rows: dict[int, dict[tuple[int, ...], str]] = {}
    for (first, *rest), text in sorted(elements.items()):
        rows.setdefault(first, {})[tuple(rest)] = text
    return f"{{{', '.join(_braces(row) for row in rows.values())}}}"


def compile_like(
    request: Request, backend: Backend, of: Program, changed: Collection[str]
) -> Compiled:
    """A variant compiled, with the name and the experiment of the model it is one of, in which some
    parameters have other values."""
    compiled = compile_model(request, backend)
    return replace(compiled, program=named_like(compiled.program, of, changed))


def named_like(program: Program, of: Program, changed: Collection[str] = ()) -> Program:
    """The program with name, experiment and figures of another one. Parameters that were `changed`
    are structural in it: their values belong to the model, and results tell them."""
    names = ("name", "description", "experiment", "figures")
    slots = tuple(
        replace(p, structural=True) if p.name in changed else p for p in program.parameter_slots
    )
    taken = {name: getattr(of, name) for name in names}
    return replace(program, parameter_slots=slots, **taken)


def _literal(parameter: ParameterSlot, value: float, type_name: str) -> str:
    match parameter.kind.value:
        case "Boolean":
            if value not in (0, 1):
                raise usage_error("C204", f"`{parameter.name}` takes true or false, not {value:g}")
            return "true" if value else "false"
        case "Integer":
            if value != int(value):
                raise usage_error("C204", f"`{parameter.name}` takes an integer, not {value:g}")
            return str(int(value))
        case "enumeration":
            if not 1 <= value <= len(parameter.literals) or value != int(value):
                raise usage_error("C204", f"`{parameter.name}` has no literal number {value:g}")
            outermost = (
                "" if type_name in PREDEFINED else "."
            )  # a leading dot does not lead to these
            return f"{outermost}{type_name}.{parameter.literals[int(value) - 1]}"
    return repr(float(value))


def _begins_within(text: str) -> bool:
    return any(line.lstrip().startswith("within ") for line in text.splitlines())


def _tree(values: Mapping[str, str]) -> _Tree:
    root: _Tree = {}
    for name, value in values.items():
        node, last = _place(root, name)
        node[last] = value
    return root


def _place(tree: _Tree, name: str) -> tuple[_Tree, str]:
    """The branch of the component that a name stands in, and its last part."""
    *path, last = name.split(".")
    for part in path:
        inside = tree.setdefault(part, {})
        assert isinstance(inside, dict)
        tree = inside
    return tree, last


def _redeclared(tree: _Tree, classes: Mapping[str, str]) -> _Tree:
    """The tree with `redeclare CLASS` in front of components."""
    # The innermost first: their own parents may be redeclared too.
    for component in sorted(classes, key=lambda n: -n.count(".")):
        node, last = _place(tree, component)
        node[f"redeclare .{classes[component]} {last}"] = node.pop(last, {})
    return tree


def _modifier(tree: _Tree) -> str:
    """`(a(b = 1))`; names nest no deeper than a model does."""
    if not tree:
        return ""
    parts = [
        f"{name} = {inside}" if isinstance(inside, str) else f"{name}{_modifier(inside)}"
        for name, inside in tree.items()
    ]
    return f"({', '.join(parts)})"
